import { useEffect, useState } from "preact/hooks";
import type { Arrays } from "../../messages.ts";
import {
  Button,
  Buttons,
  Choice,
  count,
  counted,
  Figures,
  Hint,
  List,
  Note,
  NumberField,
  Progress,
  Section,
  short,
  Slider,
  Toggle,
} from "../../ui/index.ts";
import type { Studio } from "../tab.ts";
import { page, type Sight } from "./page.ts";
import { keptAt, previewAngle } from "./scene.ts";
import type { Axis, Layout, QuadState, QuadView, Result, Wish } from "./types.ts";

type Props = { state: QuadState; view: QuadView; studio: Studio };

/** Where nothing is said. */
const usual = { quads: 2000, angle: 40, patches: 60 };
const counts = { least: 100, most: 50_000 };

/** What is wished first, then the button, then what came of it. */
export function Panel(props: Props) {
  const { state, view } = props;
  if (state.mesh === null)
    return (
      <div class="section section-body">
        <Note level="info">{view.next}</Note>
      </div>
    );
  return (
    <>
      <Size {...props} />
      <Edges {...props} />
      <More {...props} />
      <Make {...props} />
      {view.result && <Quads {...props} result={view.result} />}
      <Cage {...props} />
    </>
  );
}

// What is wished

function Size({ state, view }: Props) {
  const { quads, edge_length } = state.recipe;
  const [seen, setSeen] = useState<number | null>(null); // while it is dragged
  const area = view.wish?.area ?? null;
  const byLength = edge_length !== null;
  const number = quads ?? usual.quads;
  const settled = (answer: Promise<unknown>) => answer.finally(() => setSeen(null));
  const lengthOf = (wanted: number) => Number(Math.sqrt(area! / wanted).toPrecision(3));
  return (
    <Section title="Size" step={1}>
      <Choice
        label="By"
        value={byLength ? "length" : "number"}
        options={[
          { value: "number", label: "Number" },
          { value: "length", label: "Edge length", disabled: area === null },
        ]}
        onChange={(by) =>
          by === "length"
            ? page.change({ edge_length: lengthOf(number) })
            : page.change({ quads: Math.round(numberOf(area!, edge_length!)) })
        }
      />
      {byLength ? (
        <Slider
          label="Edge length"
          value={edge_length}
          min={Math.min(edge_length, lengthOf(counts.most))}
          max={Math.max(edge_length, lengthOf(counts.least))}
          logarithmic
          onInput={setSeen}
          onChange={(length) => settled(page.change({ edge_length: length }))}
          hint="In the unit of the mesh"
        />
      ) : (
        <Slider
          label="Quads"
          value={number}
          min={Math.min(counts.least, number)}
          max={Math.max(counts.most, number)}
          step={1}
          logarithmic
          onInput={setSeen}
          onChange={(wanted) => settled(page.change({ quads: Math.round(wanted) }))}
          hint="About how many there should be"
        />
      )}
      {area !== null && (
        <Hint>
          {byLength
            ? `About ${count(numberOf(area, seen ?? edge_length))} quads.`
            : `Edges are about ${short(Math.sqrt(area / (seen ?? number)), 3)} long.`}
        </Hint>
      )}
    </Section>
  );
}

const numberOf = (area: number, length: number) => area / (length * length);

type Sharpness = "auto" | "angle" | "none" | "given";

function Edges({ state, view, studio }: Props) {
  const { sharp } = state.recipe;
  const lines = useArrays(studio, view.wish?.lines);
  const [seen, setSeen] = useState<number | null>(null);
  const by: Sharpness =
    sharp === null ? "auto" : typeof sharp !== "number" ? "given" : sharp < 180 ? "angle" : "none";
  const angle = seen ?? (typeof sharp === "number" ? sharp : usual.angle);
  const angles = lines?.angles as Float32Array | undefined;
  const ends = lines?.edges as Uint32Array | undefined;
  const kept = angles ? keptAt(angles, angle) : (ends?.length ?? 0) / 2;
  const choices = { auto: null, angle: usual.angle, none: 180 };
  return (
    <Section title="Edges to keep" step={2}>
      <Choice
        label="Sharp edges"
        value={by}
        as="segments"
        options={[
          { value: "auto", label: "Found", hint: "Creases that look designed" },
          { value: "angle", label: "By angle", hint: "All that fold by so many degrees" },
          { value: "none", label: "None" },
          ...(by === "given"
            ? [{ value: "given" as const, label: "Given", hint: "By the recipe" }]
            : []),
        ]}
        onChange={(next) =>
          next === "given" ? undefined : page.change({ sharp: choices[next] }, "input")
        }
      />
      {by === "angle" && (
        <Slider
          label="Fold from"
          value={angle}
          min={5}
          max={120}
          step={1}
          unit="°"
          onInput={(degrees) => {
            if (page.sight !== "input") page.show("input");
            setSeen(degrees);
            if (angles) previewAngle(studio, angles, degrees);
          }}
          onChange={(degrees) =>
            page.change({ sharp: degrees }, "input").finally(() => setSeen(null))
          }
        />
      )}
      {lines && (
        <Hint>
          {kept === 0
            ? "No edges are kept: quads run over all of them."
            : `${counted(kept, "edge")} of the mesh will be kept: ${by === "none" ? "its boundary" : "boundaries, and sharp ones"}.`}
        </Hint>
      )}
      {view.wish?.large && <Hint>The mesh is too large to show them beforehand.</Hint>}
    </Section>
  );
}

/** A blob's arrays, once they are there. */
function useArrays(studio: Studio, blob: string | undefined): Arrays | null {
  const [found, setFound] = useState<{ blob: string; arrays: Arrays } | null>(null);
  useEffect(() => {
    let wanted = true;
    if (blob)
      studio.data(blob).then(
        ({ arrays }) => wanted && setFound({ blob, arrays }),
        () => {},
      );
    return () => void (wanted = false);
  }, [blob]);
  return blob && found?.blob === blob ? found.arrays : null;
}

function More({ state, view }: Props) {
  const { layout, patches, seed } = state.recipe;
  const flat = layout === "vsa";
  return (
    <Section title="Layout, density, symmetry" open={false}>
      <Choice
        label="Layout"
        value={layout}
        as="segments"
        options={[
          { value: "auto", label: "Best", hint: "By field; if that ends badly, by flat patches" },
          {
            value: "field",
            label: "Field",
            hint: "Along lines of curvature: few irregular vertices",
          },
          { value: "vsa", label: "Flat patches", hint: "Patches as flat as possible" },
        ]}
        onChange={(next: Layout) => page.change({ layout: next, patches: null })}
      />
      {(flat || patches !== null) && (
        <Toggle
          label="Choose how many patches"
          value={patches !== null}
          onChange={(chosen) => page.change({ patches: chosen ? usual.patches : null })}
        />
      )}
      {patches !== null && (
        <Slider
          label="Patches"
          value={patches}
          min={Math.min(4, patches)}
          max={Math.max(400, patches)}
          step={1}
          logarithmic
          onChange={(wanted) => page.change({ patches: Math.round(wanted) })}
        />
      )}
      <Density state={state} wish={view.wish} />
      <Symmetry state={state} />
      <NumberField
        label="Seed"
        value={seed}
        min={0}
        max={2 ** 31 - 1}
        step={1}
        digits={10}
        onChange={(next) => page.change({ seed: Math.round(next) })}
        hint="Another one gives another layout of flat patches, and mends bad quads differently"
      />
    </Section>
  );
}

const even = ""; // of densities

function Density({ state, wish }: { state: QuadState; wish: Wish | undefined }) {
  const { density } = state.recipe;
  const names = wish?.densities ?? [];
  const known = [even, "curvature", ...names];
  const options = [
    { value: even, label: "Even" },
    { value: "curvature", label: "Smaller where it bends" },
    ...names.map((name) => ({ value: name, label: `By ${name}` })),
    ...(known.includes(density ?? even) ? [] : [{ value: density!, label: density! }]),
  ];
  return (
    <Choice
      label="Density"
      value={density ?? even}
      as="select"
      options={options}
      onChange={(next) => page.change({ density: next === even ? null : next }, "input")}
      hint="Where quads are smaller"
    />
  );
}

function Symmetry({ state }: { state: QuadState }) {
  const { symmetry } = state.recipe;
  const own = symmetry !== null && typeof symmetry !== "string";
  return (
    <Choice
      label="Symmetry"
      value={symmetry === null ? "none" : own ? "own" : (symmetry as Axis)}
      as="segments"
      options={[
        { value: "none", label: "None" },
        { value: "x", label: "x" },
        { value: "y", label: "y" },
        { value: "z", label: "z" },
        ...(own ? [{ value: "own", label: "Own", hint: "The recipe's own plane" }] : []),
      ]}
      onChange={(next) =>
        next === "own"
          ? undefined
          : page.change({ symmetry: next === "none" ? null : (next as Axis) }, "input")
      }
      hint="The plane through the middle, normal to this axis"
    />
  );
}

// The button

function jobOf(studio: Studio, title: string) {
  return studio.jobs.find((one) => one.tab === "quad" && one.title === title);
}

function Make({ view, studio }: Props) {
  const job = jobOf(studio, "Make quads");
  const again = view.result && !view.result.current;
  return (
    <div class="section section-body">
      {view.next && <Note level={again ? "warning" : "info"}>{view.next}</Note>}
      {job ? (
        <Progress
          title="Making quads"
          message={job.message}
          fraction={job.fraction ?? null}
          onCancel={() => studio.cancel(job.job)}
        />
      ) : (
        <Button
          label={again ? "Make quads again" : "Make quads"}
          kind="primary"
          wide
          keys="Enter"
          disabled={view.problem !== undefined}
          hint={view.problem}
          onClick={() => void page.make("quads")}
        />
      )}
    </div>
  );
}

// What came of it

const sights: { value: Sight; label: string; hint: string }[] = [
  { value: "quads", label: "Quads", hint: "Q" },
  { value: "quality", label: "Quality", hint: "How well each quad is shaped (W)" },
  { value: "patches", label: "Patches", hint: "Which patch each quad is from (P)" },
  { value: "input", label: "Input", hint: "What they were made of (I); hold C to compare" },
];

function Quads({ view, studio, result }: Props & { result: Result }) {
  const { irregular, arcs, features } = page.shown;
  const sight = page.sight === "cage" ? "input" : page.sight;
  return (
    <Section title="Quads" aside={result.current ? undefined : "outdated"}>
      <Choice
        label="Show"
        value={sight}
        as="segments"
        options={sights}
        onChange={(next) => page.show(next)}
      />
      <Toggle
        label="Irregular vertices"
        value={irregular}
        onChange={(on) => page.set({ irregular: on })}
        hint="V"
      />
      <Toggle
        label="Patch boundaries"
        value={arcs || sight === "patches"}
        disabled={sight === "patches"}
        onChange={(on) => page.set({ arcs: on })}
        hint="L"
      />
      <Toggle
        label="Creases and boundaries"
        value={features}
        onChange={(on) => page.set({ features: on })}
        hint="G"
      />
      <List
        label="Irregular vertices by kind"
        rows={result.kinds.map((kind) => ({
          id: kind.label,
          name: kind.label[0]!.toUpperCase() + kind.label.slice(1),
          colour: kind.colour,
          detail: count(kind.count),
        }))}
      />
      <Figures label="Figures of the quads" figures={result.figures} />
      <Buttons>
        <Button
          label="Use as mesh"
          icon="mesh"
          hint="Puts them among the open meshes, so that other tabs can take them"
          onClick={() => void keep(studio, view, "quads")}
        />
      </Buttons>
    </Section>
  );
}

function Cage({ state, view, studio }: Props) {
  const job = jobOf(studio, "Make cage");
  const { cage } = state;
  return (
    <Section title="Cage" open={cage !== null}>
      <Hint>
        {cage
          ? `${counted(cage.faces, "quad")}: subdivided, they come near to the surface.`
          : "As few quads as go on as a control mesh in Design. This takes a while."}
      </Hint>
      {job ? (
        <Progress
          title="Making a cage"
          message={job.message}
          fraction={job.fraction ?? null}
          onCancel={() => studio.cancel(job.job)}
        />
      ) : (
        <Buttons>
          <Button
            label={cage ? "Make cage again" : "Make cage"}
            disabled={view.problem !== undefined}
            onClick={() => void page.make("cage")}
          />
          {cage && (
            <Button
              label="Use cage as mesh"
              icon="mesh"
              hint="Puts it among the open meshes, for Design"
              onClick={() => void keep(studio, view, "cage")}
            />
          )}
        </Buttons>
      )}
      {cage && (
        <Toggle
          label="Show the cage"
          value={page.sight === "cage"}
          onChange={(on) => page.show(on ? "cage" : view.result ? "quads" : "input")}
        />
      )}
    </Section>
  );
}

async function keep(studio: Studio, view: QuadView, what: "quads" | "cage"): Promise<void> {
  if (view.result && !view.result.current && what === "quads")
    studio.notify("info", "These quads are of settings that were changed since.");
  if (await studio.do("document", "keep", { tab: "quad", what }))
    studio.notify("info", `“${studio.state!.meshes.at(-1)!.name}” is among the open meshes now.`);
}
