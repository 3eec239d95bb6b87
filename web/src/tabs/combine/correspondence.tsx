import { useState } from "preact/hooks";
import { Button, Buttons, Choice, Hint, List, NumberField, Section } from "../../ui/index.ts";
import { Pairing, pairColour } from "../shared/pairing.ts";
import type { Studio } from "../tab.ts";
import { labelOf, page } from "./page.ts";
import { type Kind, type Props, sideNames } from "./types.ts";

const titles: Record<Kind, string> = { pairs: "Boundary pairs", landmarks: "Landmarks inside" };
const names: Record<Kind, string> = { pairs: "Pair", landmarks: "Landmark" };
const empty: Record<Kind, string> = {
  pairs: "Click along the boundaries: left, then right. At least three, in any order.",
  landmarks: "Where features inside shall meet: eyes, noses, corners. Not needed.",
};

/** The pairs of a kind. */
export function Pairs({ kind, state, view, studio }: Props & { kind: Kind }) {
  const pairs = view[kind] ?? [];
  const { pairing } = page;
  const proposed = kind === "pairs" && state.recipe.pairs === "auto" && pairs.length > 0;
  return (
    <Section title={titles[kind]} aside={pairs.length || undefined}>
      {proposed && <Hint>Proposed by shape: look, and drag what is not right.</Hint>}
      <List
        label={titles[kind]}
        empty={empty[kind]}
        rows={pairs.map(({ a, b }, index) => ({
          id: Pairing.idOf(kind, index),
          name: `${names[kind]} ${labelOf(kind, index)}`,
          colour: pairColour(index),
          detail: `${a} – ${b}`,
          hint: `Vertex ${a} of a, vertex ${b} of b`,
          selected: pairing.selected === Pairing.idOf(kind, index),
        }))}
        onSelect={(id) => pairing.select(pairing.selected === id ? null : id)}
        onRemove={(id) => {
          const index = Number(id.split(" ")[1]);
          void studio.do("combine", "remove_pair", { kind, index });
        }}
      />
      <Buttons>
        {kind === "pairs" && (
          <Button
            label="Propose"
            hint="Find boundary pairs by shape, in place of these"
            disabled={state.recipe.pairs === "auto"}
            onClick={() => void studio.do("combine", "propose")}
          />
        )}
        <Button
          label={`Clear ${kind}`}
          kind="quiet"
          hint="Take all away, to click them anew"
          disabled={pairs.length === 0}
          onClick={() => {
            void studio.do("combine", "clear", { kind });
            studio.take(kind);
          }}
        />
      </Buttons>
    </Section>
  );
}

/** Pairs without the mouse. */
export function ByNumber({ studio }: { studio: Studio }) {
  const [kind, setKind] = useState<Kind>("pairs");
  const [pair, setPair] = useState({ a: 0, b: 0 });
  return (
    <Section title="Add by vertex number" open={false}>
      <Choice<Kind>
        label="Kind"
        value={kind}
        options={[
          { value: "pairs", label: "Boundary" },
          { value: "landmarks", label: "Inside" },
        ]}
        onChange={setKind}
      />
      {sideNames.map((side) => (
        <NumberField
          key={side}
          label={`Vertex of ${side}`}
          value={pair[side]}
          min={0}
          step={1}
          digits={12}
          onChange={(vertex) => setPair({ ...pair, [side]: Math.round(vertex) })}
        />
      ))}
      <Buttons>
        <Button
          label="Add"
          icon="plus"
          onClick={() => void studio.do("combine", "add_pair", { kind, ...pair })}
        />
      </Buttons>
    </Section>
  );
}
