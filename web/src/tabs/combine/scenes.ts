/** Brings the viewports to what is looked at: both meshes, the common plane, or the morph. */

import type {
  Colours,
  Mark,
  SurfaceData,
  SurfaceView,
  View,
  Viewport,
} from "../../viewer/index.ts";
import { pairColour } from "../shared/pairing.ts";
import type { Studio } from "../tab.ts";
import { bringTo, fitAll, type Way } from "../shared/morph.ts";
import { labelOf, type Mode, modeOf, page } from "./page.ts";
import {
  type CombineState,
  type CombineView,
  type Kind,
  type Result,
  type SideName,
  sideNames,
} from "./types.ts";

/** Of the edges of a, of b, and of holes. */
export const colours = { a: "#2f6fd0", b: "#d9661f", hole: "#c0392b" };

/** What the viewports show, to leave alone what is there already. */
let shown: { mode: Mode; count: number; linked: boolean } | null = null;
/** The way that the morph goes, once its shapes are here. */
let way: Way | null = null;
/** Where the cameras were before the plane was looked at. */
let before: View | null = null;

/** The viewports were emptied. */
export function forget(): void {
  shown = way = before = null;
}

export async function scene(studio: Studio, state: CombineState, view: CombineView): Promise<void> {
  const mode = modeOf(view);
  lay(studio, mode);
  page.pairing.active = mode === "sides";
  studio.hint(page.hint(mode));
  for (const viewport of studio.viewports)
    viewport.tool = mode === "sides" ? studio.tool.viewport : "orbit";
  if (mode === "sides") await sides(studio, state, view);
  else if (mode === "plane") await plane(studio, view.result!);
  else await morph(studio, state, view.result!);
}

/** As many viewports as are needed, empty if something else was looked at before. */
function lay(studio: Studio, mode: Mode): void {
  const count = mode === "morph" || (mode === "plane" && page.overlaid) ? 1 : 2;
  const linked = page.linked || mode === "plane";
  const same = shown?.mode === mode && shown.count === count;
  if (same && shown!.linked === linked) return;
  const first = studio.viewports[0]!;
  if (mode === "plane" && shown?.mode !== "plane") before = shown && first.camera();
  studio.stage.layout(count, linked);
  if (!same) for (const viewport of studio.viewports) viewport.clear();
  // what is side by side in one plane has the same coordinates on both sides
  if (mode === "plane" || shown?.mode === "plane")
    for (const viewport of studio.viewports) viewport.settleAnew();
  if (shown?.mode === "plane" && mode !== "plane" && before) first.look(before);
  shown = { mode, count, linked };
}

/** Puts a surface into a viewport, unless it is there. */
function put(viewport: Viewport, key: string, data: SurfaceData) {
  const there = viewport.surface(key);
  return there?.data === data ? there : viewport.add(key, data);
}

// Side by side

async function sides(studio: Studio, state: CombineState, view: CombineView): Promise<void> {
  const whole = page.whole && view.result ? await edged(studio, view.result) : null;
  const groups = await Promise.all((["pairs", "landmarks"] as const).map((kind) => group(kind)));
  for (const [k, side] of sideNames.entries()) {
    const viewport = studio.viewports[k]!;
    const data = view.surfaces[side]?.data;
    const name = studio.mesh(state[side])?.name;
    viewport.title(name ? `${side}: ${name}` : "");
    viewport.legend.set(whole && k === 0 ? legend("Combined mesh") : null);
    if (data === undefined) {
      viewport.clear();
      continue;
    }
    const surface = put(viewport, side, await studio.surface(data));
    surface.style({ ...studio.look, opacity: whole ? 0 : 1 }); // clicks still mean its vertices
    for (const other of sideNames) {
      const key = `edges of ${other}`;
      if (whole) lines(put(viewport, key, whole[side][other]), other, other === "a");
      else viewport.remove(key);
    }
    viewport.lines.set(await outlines(studio, view, side));
  }
  if (view.sides) page.pairing.show(groups);

  async function group(kind: Kind) {
    const pairs = (view[kind] ?? []).map(({ a, b }) => [a, b] as const);
    const label = (index: number) => labelOf(kind, index);
    if (kind === "landmarks" || !view.sides) return { kind, pairs, label };
    const [a, b] = await Promise.all(sideNames.map((side) => outer(studio, view, side)));
    return { kind, pairs, label, places: [a!, b!] as const };
  }
}

/** The vertices that may be boundary pairs. */
async function outer(
  studio: Studio,
  view: CombineView,
  side: SideName,
): Promise<ArrayLike<number>> {
  const { sound, loops } = view.sides![side];
  const found = sound ? loops.find((loop) => loop.outer) : undefined;
  return found ? studio.numbers(found.vertices) : [];
}

/** Boundaries: the one that is matched, and holes. */
async function outlines(studio: Studio, view: CombineView, side: SideName) {
  const loops = view.sides?.[side].loops ?? [];
  return Promise.all(
    loops.map(async ({ vertex, vertices, outer }) => ({
      id: String(vertex),
      colour: outer ? colours.a : colours.hole,
      points: Array.from(await studio.numbers(vertices), (one) => ({ surface: side, vertex: one })),
      closed: true,
      width: outer ? 2 : 2.5,
    })),
  );
}

// The result

type Shapes = { a: SurfaceData; b: SurfaceData };
const known = new WeakMap<SurfaceData, Shapes>();

/** The combined mesh in both forms; the same objects while they are in use. */
async function shapes(studio: Studio, result: Result): Promise<Shapes> {
  const a = await studio.surface(result.shapes);
  const there = known.get(a);
  if (there) return there;
  const { arrays } = await studio.data(result.shapes);
  const made = { a, b: { ...a, positions: arrays.other as Float32Array } };
  known.set(a, made);
  return made;
}

/** A surface whose edges are those of a or of b, in its colour. */
function lines(surface: SurfaceView, of: SideName, faces: boolean): void {
  surface.style({ edges: true, lineColour: colours[of], faces, solid: false });
}

/** Whose edges have which colour. */
function legend(title: string) {
  const entries = sideNames.map((side) => ({ label: `edges of ${side}`, colour: colours[side] }));
  return { title, entries };
}

type Edged = Record<SideName, Shapes>;
const edgedShapes = new WeakMap<SurfaceData, Edged>();

/** The combined mesh in both forms, each once with the edges of a and once with those of b. */
async function edged(studio: Studio, result: Result): Promise<Edged> {
  const { a, b } = await shapes(studio, result);
  const there = edgedShapes.get(a);
  if (there) return there;
  const { arrays } = await studio.data(result.plane);
  const [edgesOfA, edgesOfB] = [arrays.edges_a as Uint32Array, arrays.edges_b as Uint32Array];
  const both = (form: SurfaceData): Shapes => ({
    a: { ...form, edges: edgesOfA },
    b: { ...form, edges: edgesOfB },
  });
  const made = { a: both(a), b: both(b) };
  edgedShapes.set(a, made);
  return made;
}

/** Marks where pairs are on the result. */
function marksOn(result: Result, surface: string): Mark[] {
  if (!page.marked) return [];
  return (["pairs", "landmarks"] as const).flatMap((kind) =>
    result[kind].map((vertex, index) => ({
      id: `${kind} ${index}`,
      label: labelOf(kind, index),
      colour: pairColour(index),
      position: { surface, vertex },
      selected: page.pairing.selected === `${kind} ${index}`,
    })),
  );
}

type Flat = Shapes & { disk: SurfaceData };
const flattened = new WeakMap<SurfaceData, Flat>();

/** Both flattenings, whose edges are drawn, and the disk that they fill. */
async function flat(studio: Studio, result: Result): Promise<Flat> {
  const whole = await studio.surface(result.shapes);
  const there = flattened.get(whole);
  if (there) return there;
  const { arrays } = await studio.data(result.plane);
  const positions = arrays.positions as Float32Array;
  const of = (edges: unknown): SurfaceData => ({
    ...whole,
    positions,
    edges: edges as Uint32Array,
    creases: undefined,
    centre: [0, 0, 0],
    scale: 1,
  });
  const made = { a: of(arrays.edges_a), b: of(arrays.edges_b), disk: disk(whole, positions) };
  flattened.set(whole, made);
  return made;
}

/** What a boundary in the plane encloses: triangles from its middle to its edges. */
function disk(whole: SurfaceData, plane: Float32Array): SurfaceData {
  const creases = whole.creases!;
  const middle = plane.length / 3;
  const positions = new Float32Array(plane.length + 3);
  positions.set(plane);
  const triangles = new Uint32Array((3 * creases.length) / 2);
  for (let edge = 0; edge < creases.length / 2; edge++)
    triangles.set([middle, creases[2 * edge]!, creases[2 * edge + 1]!], 3 * edge);
  return { positions, triangles, edges: new Uint32Array(), creases, centre: [0, 0, 0], scale: 1 };
}

async function plane(studio: Studio, result: Result): Promise<void> {
  const both = await flat(studio, result);
  const fresh = studio.viewports.every((viewport) => viewport.keys.length === 0);
  for (const [k, side] of sideNames.entries()) {
    const viewport = studio.viewports[page.overlaid ? 0 : k]!;
    put(viewport, "disk", both.disk).style({ edges: false });
    const surface = put(viewport, `plane ${side}`, both[side]);
    lines(surface, side, false);
    viewport.marks.set(marksOn(result, "disk"));
    viewport.title(page.overlaid ? "Overlay of both" : `${side}, flattened`);
  }
  studio.viewports[0]!.legend.set(page.overlaid ? legend("Common plane") : null);
  if (!fresh) return;
  studio.viewports[0]!.view("front");
  studio.frame();
}

async function morph(studio: Studio, state: CombineState, result: Result): Promise<void> {
  const viewport = studio.viewports[0]!;
  const { a, b } = await shapes(studio, result);
  const { path, time } = state.recipe.morph;
  const [knots, delay] = await Promise.all([
    path === "rotation" && result.turning ? studio.data(result.turning) : null,
    result.delay ? studio.data(result.delay) : null,
  ]);
  way = {
    a: a.positions,
    b: b.positions,
    knots: (knots?.arrays.knots as Float32Array | undefined) ?? null,
    delay: (delay?.arrays.values as Float32Array | undefined) ?? null,
    eased: time === "smoothstep",
  };
  const fresh = !viewport.surface("morph");
  const surface = put(viewport, "morph", a);
  surface.style({ ...studio.look });
  viewport.marks.set(marksOn(result, "morph"));
  viewport.title("");
  await paint(studio, viewport, result);
  if (fresh) fitAll(viewport, surface, way, 0.5);
  toTime(studio);
}

/** Brings the morph to the player's time. */
export function toTime(studio: Studio): void {
  const surface = studio.viewports[0]?.surface("morph");
  if (surface && way) bringTo(surface, way, page.player.time);
}

async function paint(studio: Studio, viewport: Viewport, result: Result): Promise<void> {
  const surface = viewport.surface("morph")!;
  const chosen = result.colours.find((one) => one.title === page.colour);
  const values = chosen && (await studio.data(chosen.data)).arrays;
  surface.colours(chosen && values ? coloursOf(chosen, values) : null);
  const range = chosen?.limits;
  viewport.legend.set(
    range && chosen.colormap !== "categorical"
      ? {
          title: chosen.title,
          min: range[0],
          max: range[1],
          colormap: chosen.colormap ?? "viridis",
          unit: chosen.unit,
        }
      : null,
  );
}

function coloursOf(
  { per, colormap, limits }: Result["colours"][number],
  arrays: Record<string, unknown>,
): Colours {
  if (arrays.rgb) return { rgb: arrays.rgb as Uint8Array, per };
  return {
    values: arrays.values as Float32Array,
    per,
    colormap: colormap ?? "viridis",
    min: limits?.[0] ?? 0,
    max: limits?.[1] ?? 1,
  };
}
