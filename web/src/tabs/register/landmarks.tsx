import { useRef, useState } from "preact/hooks";
import { Button, Buttons, List, NumberField, Section } from "../../ui/index.ts";
import { Pairing, pairColour } from "../shared/pairing.ts";
import type { Studio } from "../tab.ts";
import { endings, readLandmarks } from "./files.ts";
import { MARKS, page } from "./page.ts";
import { type Props, sideNames } from "./types.ts";

/** The landmarks, and other ways to get some. */
export function Landmarks({ state, view, studio }: Props) {
  const { pairing } = page;
  return (
    <Section title="Landmarks" aside={state.recipe.landmarks.length || undefined}>
      <List
        label="Landmarks"
        empty="Click a place on the source, then the same place on the target: noses, tips of limbs, ears. Three to ten make it sure; without any it is a guess."
        rows={(view.landmarks ?? []).map(({ source, target, points }, index) => ({
          id: Pairing.idOf(MARKS, index),
          name: `Landmark ${index + 1}`,
          colour: pairColour(index),
          detail: points.length ? "points" : `${source} – ${target}`,
          hint: points.length
            ? `Points near vertex ${source} of the source and vertex ${target} of the target`
            : `Vertex ${source} of the source, vertex ${target} of the target`,
          selected: pairing.selected === Pairing.idOf(MARKS, index),
        }))}
        onSelect={(id) => pairing.select(pairing.selected === id ? null : id)}
        onRemove={(id) => page.remove(Number(id.split(" ")[1]))}
      />
      <Buttons>
        <FromFiles studio={studio} />
        <Button
          label="Clear"
          kind="quiet"
          hint="Take all landmarks away"
          disabled={state.recipe.landmarks.length === 0}
          onClick={() => void studio.do("register", "clear_landmarks")}
        />
      </Buttons>
      <ByNumber studio={studio} />
    </Section>
  );
}

function FromFiles({ studio }: { studio: Studio }) {
  const input = useRef<HTMLInputElement>(null);
  return (
    <>
      <Button
        label="From files …"
        kind="quiet"
        icon="open"
        hint="One file with pairs (.json), or one for each mesh (.vts, .pp of MeshLab, .fcsv or .mrk.json of 3D Slicer)"
        onClick={() => input.current?.click()}
      />
      <input
        ref={input}
        type="file"
        multiple
        hidden
        accept={endings.join(",")}
        aria-label="Files of landmarks"
        onChange={({ currentTarget }) => {
          const files = [...(currentTarget.files ?? [])];
          currentTarget.value = ""; // so that the same file can be chosen again
          if (files.length > 0) void readLandmarks(studio, files);
        }}
      />
    </>
  );
}

/** Landmarks without the mouse. */
function ByNumber({ studio }: { studio: Studio }) {
  const [open, setOpen] = useState(false);
  const [pair, setPair] = useState({ source: 0, target: 0 });
  if (!open)
    return (
      <Buttons>
        <Button label="By vertex number …" kind="quiet" onClick={() => setOpen(true)} />
      </Buttons>
    );
  return (
    <>
      {sideNames.map((side) => (
        <NumberField
          key={side}
          label={`Vertex of the ${side}`}
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
          onClick={() => void studio.do("register", "add_landmark", pair)}
        />
      </Buttons>
    </>
  );
}
