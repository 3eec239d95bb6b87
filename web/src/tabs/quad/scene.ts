/** Brings the viewport to what the quad tab shows. */

import type {
  Hit,
  LegendContent,
  SurfaceData,
  SurfaceStyle,
  Viewport,
} from "../../viewer/index.ts";
import { count } from "../../ui/index.ts";
import type { Studio } from "../tab.ts";
import { page, type Sight } from "./page.ts";
import { beads, sheet, tubes } from "./strands.ts";
import type { QuadState, QuadView, Result } from "./types.ts";

/** CSS colours. */
const lineColour = "#d0571f"; // of edges that are kept
const arcColour = "#26323f"; // where patches meet
const planeColour = "#6f8fd8";
const cageColour = "#d0571f";

const onTop: Partial<SurfaceStyle> = { solid: false, edges: false, creases: false };

export async function scene(studio: Studio, state: QuadState, view: QuadView): Promise<void> {
  const viewport = studio.viewports[0]!;
  const sight = page.seen(view);
  const wanted = new Set<string>();
  const put = (key: string, data: SurfaceData, style: Partial<SurfaceStyle>) => {
    wanted.add(key);
    return laid(viewport, key, data, style);
  };
  if (view.surfaces.input) await input(studio, state, view, sight, put);
  if (view.result && isOfQuads(sight)) await quads(studio, view, view.result, sight, put);
  if (sight === "cage") await cage(studio, view, put);
  for (const key of viewport.keys) if (!wanted.has(key)) hideOrRemove(viewport, key, view);
  viewport.legend.set(legend(view, sight));
  viewport.title(title(view, sight));
}

/** (q,) of the quads in the picture. */
let shapes: Float32Array | null = null;

const isOfQuads = (sight: Sight) => sight !== "input" && sight !== "cage";

type Put = (
  key: string,
  data: SurfaceData,
  style: Partial<SurfaceStyle>,
) => ReturnType<typeof laid>;

/** A surface under a key, with a style; added only if it is not there. */
function laid(viewport: Viewport, key: string, data: SurfaceData, style: Partial<SurfaceStyle>) {
  const known = viewport.surface(key);
  const surface = known?.data === data ? known : viewport.add(key, data);
  surface.style({ visible: true, ...style });
  return surface;
}

/** What is still of the same mesh stays for later, so that it is there at once. */
function hideOrRemove(viewport: Viewport, key: string, view: QuadView): void {
  if (view.surfaces.input && key in view.surfaces) viewport.surface(key)!.style({ visible: false });
  else viewport.remove(key);
}

// The input, with what quads will follow

async function input(
  studio: Studio,
  state: QuadState,
  view: QuadView,
  sight: Sight,
  put: Put,
): Promise<void> {
  const { edges, shading } = studio.look;
  const data = await studio.surface(view.surfaces.input!.data);
  const visible = sight === "input" || sight === "cage";
  const lines = view.wish?.lines;
  const surface = put("input", data, {
    visible,
    edges: edges && sight === "input",
    creases: !lines && sight === "input",
    shading,
  });
  if (!visible) return;
  const sizes = sight === "input" ? view.wish?.sizes : undefined;
  await once(surface, sizes?.data ?? "", async () => {
    if (!sizes) return surface.colours(null);
    const values = (await studio.data(sizes.data)).arrays.values as Float32Array;
    const [min, max] = sizes.limits;
    surface.colours({ values, per: "vertex", colormap: "viridis", min, max });
  });
  if (sight !== "input") return;
  if (lines && page.shown.features) {
    const { arrays } = await studio.data(lines);
    const kept = derived("lines", `${view.surfaces.input!.data} ${lines}`, () => ({
      ...data,
      edges: new Uint32Array(0),
      creases: arrays.edges as Uint32Array,
    }));
    const style = { faces: false, creaseColour: lineColour, solid: false, edges: false };
    const shown = put("lines", kept, { ...style, creases: true });
    const { sharp } = state.recipe;
    const angles = arrays.angles as Float32Array | undefined;
    if (angles && typeof sharp === "number") shown.creasesUpTo(keptAt(angles, sharp));
  }
  const plane = view.wish?.plane;
  if (plane) {
    const key = `${view.surfaces.input!.data} ${JSON.stringify(plane)}`;
    const rectangle = derived("plane", key, () => sheet(data, plane));
    put("plane", rectangle, { ...onTop, creases: true, colour: planeColour, opacity: 0.2 });
  }
}

/** Where colours of shapes end: at 0, where quads fold, or half way if none is as bad. */
const leastShape = (view: QuadView) => (view.result!.worst > 0.5 ? 0.5 : 0);

/** How many of edges that are sorted by falling angles fold by so many degrees. */
export function keptAt(angles: Float32Array, degrees: number): number {
  let [low, high] = [0, angles.length];
  while (low < high) {
    const middle = (low + high) >> 1;
    if (angles[middle]! >= degrees) low = middle + 1;
    else high = middle;
  }
  return low;
}

/** Shows at once which edges an angle would keep, while it is being chosen. */
export function previewAngle(studio: Studio, angles: Float32Array, degrees: number): void {
  studio.viewports[0]?.surface("lines")?.creasesUpTo(keptAt(angles, degrees));
}

// The quads

async function quads(
  studio: Studio,
  view: QuadView,
  result: Result,
  sight: Sight,
  put: Put,
): Promise<void> {
  const { edges, shading } = studio.look;
  const { irregular, arcs, features } = page.shown;
  const blob = view.surfaces.quads!.data;
  const data = await studio.surface(blob);
  const details = (await studio.data(result.details)).arrays;
  shapes = details.shape as Float32Array;
  const surface = put("quads", data, {
    edges,
    shading,
    creases: features && !arcs && sight !== "patches",
    creaseColour: lineColour,
  });
  await once(surface, `${sight} ${result.details}`, () => {
    if (sight === "quality") {
      const values = details.shape as Float32Array;
      const min = leastShape(view);
      surface.colours({ values, per: "face", colormap: "quality", min, max: 1 });
    } else if (sight === "patches") {
      surface.colours({ rgb: details.patch as Uint8Array, per: "face" });
    } else surface.colours(null);
  });
  if (arcs || sight === "patches") {
    const along = derived("arcs", result.details, () => tubes(data, details.arcs as Uint32Array));
    put("arcs", along, { ...onTop, colour: arcColour });
  }
  if (irregular && details.irregular!.length > 0) {
    const kinds = result.kinds.map(({ colour }) => bytes(colour));
    const marks = derivedMarks(result.details, () => {
      const made = beads(data, details.irregular as Uint32Array);
      const kind = details.kind as Uint8Array;
      const rgb = new Uint8Array(made.data.positions.length);
      for (let i = 0; i < rgb.length; i++) {
        const bead = Math.floor(i / (3 * made.corners));
        rgb[i] = kinds[kind[bead]!]![i % 3]!;
      }
      return { data: made.data, rgb };
    });
    const shown = put("irregular", marks.data, onTop);
    await once(shown, result.details, () => shown.colours({ rgb: marks.rgb, per: "vertex" }));
  }
}

async function cage(studio: Studio, view: QuadView, put: Put): Promise<void> {
  const data = await studio.surface(view.surfaces.cage!.data);
  put("cage", data, {
    ...{ solid: false, opacity: 0.22, colour: cageColour },
    ...{ lineColour: cageColour, creaseColour: cageColour, edges: true },
  });
}

function title(view: QuadView, sight: Sight): string {
  if (page.comparing) return sight === "input" ? "Input" : "Quads";
  const old = isOfQuads(sight) && view.result && !view.result.current;
  return old ? "Settings were changed since these quads were made" : "";
}

function legend(view: QuadView, sight: Sight): LegendContent | null {
  if (sight === "quality")
    return {
      ...{ title: "Shape (scaled Jacobian)", colormap: "quality" },
      ...{ min: leastShape(view), max: 1 },
    };
  if (sight === "input" && view.wish?.sizes) {
    const [min, max] = view.wish.sizes.limits;
    return { title: "Edge length of quads", min, max, colormap: "viridis" };
  }
  if (!view.result || !isOfQuads(sight) || !page.shown.irregular) return null;
  const entries = view.result.kinds
    .filter((kind) => kind.count > 0)
    .map((kind) => ({ label: `${kind.label}: ${count(kind.count)}`, colour: kind.colour }));
  return entries.length > 0 ? { title: "Irregular vertices", entries } : null;
}

// What was made for the picture, kept until it is made of something else

const made = new Map<string, { of: string; data: unknown }>();

function kept<Data>(what: string, of: string, make: () => Data): Data {
  const known = made.get(what);
  if (known?.of === of) return known.data as Data;
  const data = make();
  made.set(what, { of, data });
  return data;
}

const derived = (what: string, of: string, make: () => SurfaceData) => kept(what, of, make);
const derivedMarks = (of: string, make: () => { data: SurfaceData; rgb: Uint8Array }) =>
  kept("irregular", of, make);

const done = new WeakMap<object, string>();

/** Does something to a surface, unless it was the last thing done to it. */
async function once(surface: object, what: string, act: () => void | Promise<void>): Promise<void> {
  if ((done.get(surface) ?? "") === what) return;
  done.set(surface, what);
  await act();
}

function bytes(css: string): number[] {
  return [1, 3, 5].map((at) => parseInt(css.slice(at, at + 2), 16));
}

/** Tells of the quad under the pointer. */
export function inspect(studio: Studio, hit: Hit | null): void {
  const shape = hit?.surface === "quads" && !hit.snapped ? shapes?.[hit.face] : undefined;
  studio.hint(shape === undefined ? null : `Quad ${hit!.face}: shape ${shape.toFixed(3)}`);
}
