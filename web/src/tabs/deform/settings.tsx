import { useState } from "preact/hooks";
import { Button, Buttons, Choice, Hint, List, NumberField, Section } from "../../ui/index.ts";
import type { Studio } from "../tab.ts";
import type { DeformState, DeformView, FeaturePart } from "./types.ts";

type Props = { state: DeformState; view: DeformView; studio: Studio };

/** How it is deformed. */
export function Settings({ state, view, studio }: Props) {
  const { method } = state.recipe;
  return (
    <Section title="Method" open={false}>
      <Choice
        label="Method"
        value={method}
        options={[
          { value: "linear", label: "Linear", hint: "Quick, for moves and small turns" },
          { value: "refined", label: "Refined", hint: "For large turns; slower" },
        ]}
        onChange={(next) => change(studio, { method: next })}
      />
      <Symmetry state={state} studio={studio} />
      <Offsets state={state} view={view} studio={studio} />
    </Section>
  );
}

const change = (studio: Studio, recipe: object) => studio.do("deform", "change", { recipe });

const axes = ["x", "y", "z"] as const;

function Symmetry({ state, studio }: { state: DeformState; studio: Studio }) {
  const { symmetry } = state.recipe;
  const across = symmetry?.normal.map(Math.abs) ?? [];
  const axis = axes.find((_, k) => across[k]! > 0 && across.every((part, j) => j === k || !part));
  const value = symmetry ? (axis ?? "other") : "none";
  const point = axis && symmetry!.point[axes.indexOf(axis)];
  return (
    <>
      <Choice
        label="Symmetry"
        hint="The result is the mirror image of itself about this plane"
        as="segments"
        value={value}
        options={[
          { value: "none", label: "None" },
          ...axes.map((one) => ({ value: one, label: one, hint: `A plane across ${one}` })),
          ...(value === "other" ? [{ value: "other" as const, label: "As in recipe" }] : []),
        ]}
        onChange={async (next) => {
          if (next === "other") return;
          await studio.do("deform", "mirror", { axis: next === "none" ? null : next });
        }}
      />
      {axis && (
        <NumberField
          label={`Plane at ${axis}`}
          value={point!}
          onChange={(at) => studio.do("deform", "mirror", { axis, at })}
        />
      )}
    </>
  );
}

/** Pairs of features that keep their offset. */
function Offsets({ state, view, studio }: Props) {
  const { offsets } = state.recipe;
  const features = (view.parts ?? []).filter(
    (part): part is FeaturePart => part.kind === "features" && part.several === 1,
  );
  const names = features.map((part) => part.name);
  const [pair, setPair] = useState<[string, string]>(["", ""]);
  if (names.length < 2) return null;
  const first = names.includes(pair[0]) ? pair[0] : names[0]!;
  const others = names.filter((name) => name !== first);
  const second = others.includes(pair[1]) ? pair[1] : others[0]!;
  const options = (from: readonly string[]) => from.map((name) => ({ value: name, label: name }));
  const known = offsets.some(({ between }) => between.includes(first) && between.includes(second));
  const set = (next: typeof offsets) => change(studio, { offsets: next });
  return (
    <>
      <List
        label="Offsets"
        rows={offsets.map(({ between }, k) => ({
          id: String(k),
          name: between.join(" – "),
          hint: "The offset between them stays as it is",
        }))}
        onRemove={(id) => void set(offsets.filter((_, k) => String(k) !== id))}
      />
      <Choice
        label="Offset from"
        as="select"
        value={first}
        options={options(names)}
        onChange={(name) => setPair([name, second])}
      />
      <Choice
        label="to"
        as="select"
        value={second}
        options={options(others)}
        onChange={(name) => setPair([first, name])}
      />
      <Buttons>
        <Button
          label="Keep this offset"
          hint="The two features stay parallel and as far apart as they are"
          disabled={known}
          onClick={() => void set([...offsets, { name: null, between: [first, second] }])}
        />
      </Buttons>
      {offsets.length === 0 && <Hint>Two features can keep their offset to each other.</Hint>}
    </>
  );
}
