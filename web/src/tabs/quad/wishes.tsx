/** What the quads shall be: how many, along which edges, where smaller, symmetric or not. */

import { useEffect, useState } from "preact/hooks";
import type { Arrays } from "../../messages.ts";
import {
  Choice,
  count,
  Hint,
  NumberField,
  Section,
  short,
  Slider,
  Toggle,
} from "../../ui/index.ts";
import type { Studio } from "../tab.ts";
import { page } from "./page.ts";
import { keptAt, previewAngle } from "./scene.ts";
import type { Axis, Layout, QuadState, QuadView, Wish } from "./types.ts";

type Props = { state: QuadState; view: QuadView; studio: Studio };

/** Where nothing is said. */
const usual = { quads: 2000, angle: 40, patches: 60 };
const counts = { least: 100, most: 50_000 };

export function Size({ state, view }: Props) {
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
          onCancel={() => setSeen(null)}
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
          onCancel={() => setSeen(null)}
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

export function Edges({ state, view, studio }: Props) {
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
            if (page.sight(view) !== "input") page.show("input");
            setSeen(degrees);
            if (angles) previewAngle(studio, angles, degrees);
          }}
          onChange={(degrees) =>
            page.change({ sharp: degrees }, "input").finally(() => setSeen(null))
          }
        />
      )}
      {lines && <Hint>{toldKept(view.wish!.border, kept - view.wish!.border, by)}</Hint>}
      {view.wish?.large && <Hint>The mesh is too large to show them beforehand.</Hint>}
    </Section>
  );
}

/** How many edges will be kept. */
function toldKept(border: number, sharp: number, by: Sharpness): string {
  const parts = [
    border > 0 ? `${count(border)} on boundaries` : "",
    sharp > 0 ? `${count(sharp)} sharp ones` : "",
  ].filter(Boolean);
  if (parts.length > 0) return `Edges that quads will follow: ${parts.join(", ")}.`;
  return by === "none" || by === "given" ? "Quads run over all edges." : "There are none.";
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

export function More({ state, view }: Props) {
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
