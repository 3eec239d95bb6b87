import {
  Button,
  Buttons,
  Choice,
  count,
  Hint,
  IconButton,
  List,
  Section,
  Slider,
} from "../../ui/index.ts";
import type { Studio } from "../tab.ts";
import { memory } from "./memory.ts";
import { modeOf } from "./selecting.ts";
import { colours, type DeformState, type DeformView, type Found } from "./types.ts";

const most = 200; // rows that are listed
const kinds = {
  rim: "Rims",
  hole: "Holes",
  boss: "Bosses",
  line: "Lines",
  pad: "Pads",
} as const;

type Props = { state: DeformState; view: DeformView; studio: Studio };

/** What was found on the surface; what is ticked keeps its shape. */
export function FoundOnSurface({ state, view, studio }: Props) {
  const { found } = view;
  if (!found) return <NotSought studio={studio} />;
  const present = Object.entries(kinds).filter(([kind]) => found.some((one) => one.kind === kind));
  const filter = present.some(([kind]) => kind === memory.filter) ? memory.filter : "all";
  const listed = found.filter((one) => filter === "all" || one.kind === filter);
  return (
    <Section
      title="Found on the surface"
      aside={
        found.length > 0 && (
          <IconButton
            icon="list"
            size={14}
            label="Names on the surface"
            hint="a click on one ticks it"
            pressed={memory.names}
            onClick={() => {
              memory.names = !memory.names;
              studio.changed();
            }}
          />
        )
      }
    >
      {found.length === 0 ? (
        <Hint>No holes, rims, bosses, lines or pads were found. Select regions by hand.</Hint>
      ) : (
        <>
          {present.length > 1 && (
            <Choice
              label="Show"
              as="select"
              value={filter}
              options={[
                { value: "all", label: `All (${count(found.length)})` },
                ...present.map(([kind, label]) => ({
                  value: kind,
                  label: `${label} (${count(found.filter((one) => one.kind === kind).length)})`,
                })),
              ]}
              onChange={(next) => {
                memory.filter = next;
                studio.changed();
              }}
            />
          )}
          <div style={{ maxHeight: "11em", overflowY: "auto", paddingRight: "10px" }}>
            <List
              label="Found on the surface"
              rows={listed.slice(0, most).map((one) => ({
                id: one.name,
                name: one.name,
                detail: one.figures.split(",")[0],
                hint: `${one.figures}\nTick: keeps its shape. Click on the name: selects it.`,
                colour: one.part === null ? undefined : colours.features,
                ticked: one.part !== null,
              }))}
              onTick={(name, kept) => studio.do("deform", "keep", { names: [name], kept })}
              onSelect={(name, event) =>
                void studio.do("deform", "select_region", {
                  region: name,
                  mode: modeOf({ shift: event.shiftKey, ctrl: event.ctrlKey || event.metaKey }),
                })
              }
              onHover={(name) => hover(studio, name)}
            />
          </div>
          {listed.length > most && <Hint>and {count(listed.length - most)} more</Hint>}
          <AllHoles found={found} studio={studio} />
        </>
      )}
      <Folds state={state} studio={studio} />
    </Section>
  );
}

/** How sharp an edge is that belongs to a line. */
function Folds({ state, studio }: { state: DeformState; studio: Studio }) {
  const { finding } = state.recipe;
  return (
    <Slider
      label="Lines from"
      hint="Degrees by which the surface folds at a line that is found; 15 for the soft lines of outer panels. What is found may get other names with it"
      value={finding.angle}
      min={5}
      max={90}
      step={1}
      unit="°"
      onChange={(angle) =>
        studio.do("deform", "change", { recipe: { finding: { ...finding, angle } } })
      }
    />
  );
}

/** Ticks all holes, or none. */
function AllHoles({ found, studio }: { found: readonly Found[]; studio: Studio }) {
  const holes = found.filter((one) => one.kind === "hole");
  if (holes.length < 2) return null;
  const open = holes.filter((one) => one.part === null);
  const names = (open.length > 0 ? open : holes).map((one) => one.name);
  return (
    <Buttons>
      <Button
        label={open.length > 0 ? "Keep all holes" : "Keep no hole"}
        hint="Every hole keeps its shape"
        onClick={() => void studio.do("deform", "keep", { names, kept: open.length > 0 })}
      />
    </Buttons>
  );
}

function NotSought({ studio }: { studio: Studio }) {
  return (
    <Section title="Found on the surface">
      <Hint>On a mesh of this size, looking for features takes a while.</Hint>
      <Button label="Find holes, lines and pads" onClick={() => void studio.do("deform", "find")} />
    </Section>
  );
}

/** Lights something up on the surface. */
export function hover(studio: Studio, name: string | null): void {
  if (memory.hovered === name) return;
  memory.hovered = name;
  studio.changed();
}
