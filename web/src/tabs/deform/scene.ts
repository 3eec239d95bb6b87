/** Brings the viewport to the state: the surface, tints of parts and selection, marks, the gizmo. */

import type { Vector } from "../../ui/index.ts";
import type { Mark, Region, SurfaceView, Viewport } from "../../viewer/index.ts";
import type { Studio } from "../tab.ts";
import { recolour } from "./heat.ts";
import { chosen, memory } from "./memory.ts";
import { endMoving, move, startMoving } from "./moving.ts";
import { movePin } from "./pinning.ts";
import { foundMark, pinMark } from "./selecting.ts";
import {
  colours,
  isRegion,
  type DeformState,
  type DeformView,
  type Part,
  type PinPart,
} from "./types.ts";

const radians = Math.PI / 180;
const faint = 0.3; // opacity of the surface at rest behind the deformed one

let tinted = "";
let highlighted: string | null = null;

/** The viewport is empty: all is to be put into it anew. */
export function forget(): void {
  tinted = "";
  highlighted = null;
}

export async function scene(studio: Studio, state: DeformState, view: DeformView): Promise<void> {
  const viewport = studio.viewports[0]!;
  const drawn = view.surfaces.mesh;
  if (!drawn) {
    forget();
    return viewport.clear();
  }
  const data = await studio.surface(drawn.data);
  let surface = viewport.surface("mesh");
  if (surface?.data !== data) {
    viewport.remove("rest");
    surface = viewport.add("mesh", data, studio.look);
    forget();
    chooseFirst(view);
  }
  compare(studio, viewport, surface);
  viewport.brushRadius = memory.brush * data.scale;
  viewport.brushColour = colours.selection;
  await tint(studio, surface, state, view);
  await highlight(studio, surface, view);
  viewport.marks.set(marks(view));
  attach(studio, viewport, view);
  recolour(studio, memory.dragged === null);
}

/** On a mesh that was just opened, the handle that can be dragged at once is. */
function chooseFirst(view: DeformView): void {
  const first = view.parts?.find((part) => part.kind === "handles");
  if (first && !chosen(view)) memory.part = { kind: first.kind, name: first.name };
}

/** Shows the surface, that at rest, or both. */
function compare(studio: Studio, viewport: Viewport, surface: SurfaceView): void {
  const { comparing, ghost } = memory;
  const { edges, shading } = studio.look;
  const drawn = { ...studio.look, visible: !comparing };
  const { styled } = surface;
  if (styled.edges !== edges || styled.shading !== shading || styled.visible === comparing)
    surface.style(drawn);
  if (!comparing && !ghost) return viewport.remove("rest");
  const rest = viewport.surface("rest") ?? viewport.add("rest", surface.data);
  if (comparing) rest.style({ ...studio.look, opacity: 1, creases: true, solid: false });
  else rest.style({ edges: false, creases: false, opacity: faint, solid: false });
}

/** Tints parts and selection, if they are others than those tinted. */
async function tint(
  studio: Studio,
  surface: SurfaceView,
  state: DeformState,
  view: DeformView,
): Promise<void> {
  const parts = memory.heat === "none" ? (view.parts ?? []).filter(isRegion) : [];
  const look = chosen(view);
  const key = JSON.stringify([
    state.selection,
    parts.map(({ kind, ids }) => [kind, ids]),
    look && isRegion(look) && look.ids,
  ]);
  if (key === tinted) return;
  const regions: Region[] = await Promise.all(
    parts.map(async (part) => ({
      ids: (await studio.data(part.ids)).arrays.values!,
      colour: part === look ? stronger(colours[part.kind]) : colours[part.kind],
    })),
  );
  regions.push({ ids: await studio.numbers(state.selection), colour: colours.selection });
  surface.regions(regions);
  tinted = key;
  highlighted = null;
}

/** A colour that stands out among those of its kind. */
function stronger(colour: string): string {
  const part = (k: number) => Math.round(parseInt(colour.slice(k, k + 2), 16) * 0.72);
  return `rgb(${part(1)}, ${part(3)}, ${part(5)})`;
}

/** Lights up what is under the pointer in the list. */
async function highlight(studio: Studio, surface: SurfaceView, view: DeformView): Promise<void> {
  if (highlighted === memory.hovered) return;
  const wanted = memory.hovered;
  const found = view.found?.find((one) => one.name === wanted);
  const part = view.parts?.filter(isRegion).find((one) => `part ${one.name}` === wanted);
  const ids = found?.ids ?? part?.ids;
  const values = ids && (await studio.data(ids)).arrays.values!;
  surface.highlight(values ? { ids: values, colour: colours.found } : null);
  highlighted = wanted;
}

function marks(view: DeformView): Mark[] {
  const pins = (view.parts ?? []).filter((part) => part.kind === "pins");
  const named = (view.found ?? []).filter((one) => memory.names || one.name === memory.hovered);
  return [
    ...named.map(({ name, at, part }) => ({
      id: foundMark + name,
      label: name,
      colour: part === null ? colours.found : colours.features,
      position: { surface: "mesh", vertex: at },
    })),
    ...pins.map((pin) => ({
      id: pinMark + pin.name,
      label: pin.name,
      colour: colours.pins,
      position: pin.vertex === null ? pin.to : { surface: "mesh", vertex: pin.vertex },
      selected: memory.part?.kind === "pins" && memory.part.name === pin.name,
    })),
  ];
}

/** Puts arrows and rings at the handle or pin whose controls are shown. */
function attach(studio: Studio, viewport: Viewport, view: DeformView): void {
  const movable = studio.tool.name === "move" && !memory.comparing && !view.preparing;
  const part = movable ? chosen(view) : undefined;
  if (part?.kind === "handles") attachToHandle(studio, viewport, part);
  else if (part?.kind === "pins") attachToPin(studio, viewport, part);
  else viewport.gizmo.detach();
}

function attachToHandle(
  studio: Studio,
  viewport: Viewport,
  part: Extract<Part, { kind: "handles" }>,
): void {
  const { translation, rotation } = memory.dragged ?? part.move;
  viewport.gizmo.attach(
    {
      position: part.centre,
      translation,
      rotation: rotation.map((angle) => angle * radians) as Vector,
      modes: ["translate", "rotate"],
    },
    {
      onStart: () => startMoving(studio, part),
      onChange: (pose) => move(studio, pose),
      onEnd: () => void endMoving(studio),
    },
  );
}

function attachToPin(studio: Studio, viewport: Viewport, pin: PinPart): void {
  const at = (by: readonly number[]) => pin.to.map((part, k) => part + by[k]!) as Vector;
  viewport.gizmo.attach(
    { position: pin.to, modes: ["translate"] },
    {
      onChange: ({ translation }) =>
        studio.live("deform", "move_pin", { name: pin.name, to: at(translation) }),
      onEnd: ({ translation }) => void movePin(studio, pin.name, at(translation)),
    },
  );
}
