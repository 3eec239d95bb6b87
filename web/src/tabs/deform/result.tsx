import { Choice, Figures, Section, Toggle } from "../../ui/index.ts";
import type { Studio } from "../tab.ts";
import { recolour } from "./heat.ts";
import { memory } from "./memory.ts";
import type { DeformView } from "./types.ts";

/** What became of the surface. */
export function Result({ view, studio }: { view: DeformView; studio: Studio }) {
  return (
    <Section title="Result">
      <Choice
        label="Colours"
        value={memory.heat}
        options={[
          { value: "none", label: "Parts" },
          { value: "displacement", label: "Moved", hint: "How far each vertex has moved" },
          { value: "stretch", label: "Stretch", hint: "How much edges became longer or shorter" },
        ]}
        onChange={(heat) => {
          memory.heat = heat;
          recolour(studio, true);
          studio.changed();
        }}
      />
      <Toggle
        label="Rest behind it"
        hint="Hold C to see the surface at rest instead"
        value={memory.ghost}
        onChange={(ghost) => {
          memory.ghost = ghost;
          studio.changed();
        }}
      />
      <Figures label="Figures of the result" figures={view.figures ?? []} />
    </Section>
  );
}
