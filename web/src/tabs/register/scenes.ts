/** Brings the viewports to what is looked at: both meshes, or the model over the target. */

import type { Mark, SurfaceData, SurfaceView, View, Viewport } from "../../viewer/index.ts";
import { bringTo, fitAll, type Way } from "../shared/morph.ts";
import { pairColour } from "../shared/pairing.ts";
import type { Studio } from "../tab.ts";
import { MARKS, type Mode, page } from "./page.ts";
import {
  type HeatMap,
  type Marked,
  type RegisterState,
  type RegisterView,
  type Result,
  type SideName,
  sideNames,
} from "./types.ts";

/** Keys of surfaces: on its way, whose positions the server sends, and done. */
export const LIVE = "model";
export const DONE = "registered";

const ghost = { colour: "#7d8b99", opacity: 0.22 };
const bridgedColour = "#e8892b";

/** What the viewports show, to leave alone what is there already. */
let shown: { mode: Mode; linked: boolean } | null = null;
/** The way that the morph goes, once its shapes are here. */
let way: Way | null = null;

/** Where the camera was when both meshes were looked at last, if it is to go back there. */
let before: View | null = null;

/** The viewports were emptied. */
export function forget(): void {
  shown = way = before = null;
}

export async function scene(
  studio: Studio,
  state: RegisterState,
  view: RegisterView,
): Promise<void> {
  const mode = page.shown;
  lay(studio, mode);
  page.pairing.active = mode === "sides";
  studio.hint(page.hint());
  for (const viewport of studio.viewports)
    viewport.tool = mode === "sides" ? studio.tool.viewport : "orbit";
  if (mode === "sides") return sides(studio, state, view);
  await model(studio, state, view);
}

/** As many viewports as are needed, empty if something else was looked at before. */
function lay(studio: Studio, mode: Mode): void {
  const { linked } = page;
  if (shown?.mode === mode && shown.linked === linked) return;
  if (shown?.mode === "sides" && mode === "model") before = studio.viewports[0]!.camera();
  studio.stage.layout(mode === "sides" ? 2 : 1, linked);
  if (shown?.mode !== mode) for (const viewport of studio.viewports) viewport.clear();
  shown = { mode, linked };
}

/** Puts a surface into a viewport, unless it is there. */
function put(viewport: Viewport, key: string, data: SurfaceData): SurfaceView {
  const there = viewport.surface(key);
  return there?.data === data ? there : viewport.add(key, data);
}

// Side by side

async function sides(studio: Studio, state: RegisterState, view: RegisterView): Promise<void> {
  for (const [k, side] of sideNames.entries()) {
    const viewport = studio.viewports[k]!;
    const data = view.surfaces[side]?.data;
    const name = studio.mesh(state[side])?.name;
    viewport.title(name ? `${side}: ${name}` : side);
    if (data === undefined) viewport.clear();
    else put(viewport, side, await studio.surface(data)).style({ ...studio.look });
  }
  page.pairing.show([group(view.landmarks ?? [])]);
  if (before) studio.viewports[0]!.look(before);
  before = null;
}

function group(marked: readonly Marked[]) {
  return {
    kind: MARKS,
    pairs: marked.map(({ source, target }) => [source, target] as const),
    label: (index: number) => String(index + 1),
    at: (index: number, side: number) => marked[index]?.points[side] ?? null,
  };
}

// The model

async function model(studio: Studio, state: RegisterState, view: RegisterView): Promise<void> {
  const viewport = studio.viewports[0]!;
  const { job } = page;
  const fresh = !viewport.surface(job ? LIVE : DONE);
  const data = view.surfaces.target?.data;
  if (data === undefined) return;
  const target = put(viewport, "target", await studio.surface(data));
  const [source, other] = sideNames.map((side) => studio.mesh(state[side])?.name ?? "");
  viewport.title(job ? `${source} on its way to ${other}` : `${source} on ${other}`);
  if (job) await live(studio, view, viewport, target);
  else await done(studio, state, view.result!, viewport, target);
  if (!fresh) return;
  const morphing = viewport.surface(DONE);
  if (!morphing || !way) return viewport.frame();
  fitAll(viewport, morphing, way, 1);
  toTime(studio);
}

/** The source where it is just now. */
async function live(
  studio: Studio,
  view: RegisterView,
  viewport: Viewport,
  target: SurfaceView,
): Promise<void> {
  const data = await travelling(studio, view.surfaces.source!.data, target.data);
  viewport.remove(DONE);
  put(viewport, LIVE, data).style({ ...studio.look });
  viewport.legend.set(null);
  viewport.marks.set([]);
  target.colours(null);
  behind(target);
}

const known = new WeakMap<SurfaceData, SurfaceData>();

/** The source in the frame of the target, in which it comes; the same object while it is in use. */
async function travelling(studio: Studio, id: string, to: SurfaceData): Promise<SurfaceData> {
  const source = await studio.surface(id);
  const there = known.get(source);
  if (there && there.scale === to.scale && there.centre === to.centre) return there;
  const made = { ...source, centre: to.centre, scale: to.scale };
  known.set(source, made);
  return made;
}

/** The target, to be seen through. */
function behind(target: SurfaceView): void {
  target.style({ ...ghost, edges: false, creases: false, solid: false, visible: page.ghost });
}

async function done(
  studio: Studio,
  state: RegisterState,
  result: Result,
  viewport: Viewport,
  target: SurfaceView,
): Promise<void> {
  viewport.remove(LIVE);
  const data = await studio.surface(result.shapes);
  const { arrays } = await studio.data(result.shapes);
  const { path, time } = state.recipe.morph;
  const [knots, delay] = await Promise.all([
    path === "rotation" && result.turning ? studio.data(result.turning) : null,
    result.delay ? studio.data(result.delay) : null,
  ]);
  way = {
    a: arrays.start as Float32Array,
    b: data.positions,
    knots: (knots?.arrays.knots as Float32Array | undefined) ?? null,
    delay: (delay?.arrays.values as Float32Array | undefined) ?? null,
    eased: time === "smoothstep",
  };
  const surface = put(viewport, DONE, data);
  surface.regions([{ ids: arrays.bridged as Uint32Array, colour: bridgedColour }]);
  const heat = heatOf(result);
  await paint(studio, viewport, heat, { model: surface, target });
  viewport.marks.set(marks(result, heat));
  toTime(studio);
}

export function heatOf(result: Result): HeatMap | undefined {
  return result.colours.find((one) => one.title === page.colour);
}

/** Model and target in their colours; one of them is seen through, or is only lines. */
async function paint(
  studio: Studio,
  viewport: Viewport,
  heat: HeatMap | undefined,
  surfaces: Record<HeatMap["on"], SurfaceView>,
): Promise<void> {
  const { model: own, target } = surfaces;
  const values = heat && ((await studio.data(heat.data)).arrays.values as Float32Array);
  for (const on of ["model", "target"] as const) {
    const coloured = heat?.on === on && values;
    surfaces[on].colours(
      coloured
        ? {
            values,
            per: heat.per,
            colormap: heat.colormap,
            min: heat.limits[0],
            max: heat.limits[1],
          }
        : null,
    );
  }
  const onTarget = heat?.on === "target";
  own.style({ ...studio.look, faces: !onTarget, solid: !onTarget });
  if (onTarget)
    target.style({
      ...studio.look,
      edges: false,
      creases: false,
      colour: null,
      opacity: 1,
      solid: true,
      visible: true,
    });
  else behind(target);
  viewport.legend.set(
    heat
      ? {
          title: heat.title,
          min: heat.limits[0],
          max: heat.limits[1],
          colormap: heat.colormap,
          unit: heat.unit,
        }
      : null,
  );
}

/** Landmarks on the model, and the place that is missed most. */
function marks(result: Result, heat: HeatMap | undefined): Mark[] {
  const own = result.landmarks.map((vertex, index) => ({
    id: `${MARKS} ${index}`,
    label: String(index + 1),
    colour: pairColour(index),
    position: { surface: DONE, vertex },
  }));
  const worst = { id: "missed", label: "farthest", colour: "#ffffff" };
  return [
    ...(page.marked ? own : []),
    ...(heat?.on === "target" && result.missed !== null
      ? [{ ...worst, position: { surface: "target" as SideName, vertex: result.missed } }]
      : []),
  ];
}

/** Brings the model to the player's time. */
export function toTime(studio: Studio): void {
  const surface = studio.viewports[0]?.surface(DONE);
  if (surface && way) bringTo(surface, way, page.player.time);
}
