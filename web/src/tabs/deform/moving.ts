/** Dragging a handle: translations are blended here, all else is sent and comes back. */

import type { Message } from "../../messages.ts";
import type { BasisHeader } from "../../state.ts";
import type { Vector } from "../../ui/index.ts";
import type { Studio } from "../tab.ts";
import { recolour } from "./heat.ts";
import { memory, soon } from "./memory.ts";
import type { HandlePart, Move } from "./types.ts";

/** What the gizmo tells, in space and radians. */
interface Pose {
  translation: readonly number[];
  rotation: readonly number[];
}

interface Drag {
  name: string;
  from: Move;
  now: Move;
  /** How the surface answers translations, once the server has said it. */
  basis: { start: Float32Array; response: Float32Array } | null;
  dropped: boolean;
}

let drag: Drag | null = null;

const degrees = 180 / Math.PI;
const same = (a: readonly number[], b: readonly number[]) => a.every((part, k) => part === b[k]);
const close = (a: readonly number[], b: readonly number[], within: number) =>
  a.every((part, k) => Math.abs(part - b[k]!) <= within);

export function startMoving(studio: Studio, part: HandlePart): void {
  drag = { name: part.name, from: part.move, now: part.move, basis: null, dropped: false };
  studio.grab("deform", { name: part.name });
}

/** How the surface answers is known from now on. */
export function takeBasis(studio: Studio, { header, arrays }: Message<BasisHeader>): void {
  if (!drag || drag.dropped || header.name !== drag.name) return;
  const { start, response } = arrays;
  drag.basis = { start: start as Float32Array, response: response as Float32Array };
  blend(studio);
}

export function move(studio: Studio, pose: Pose): void {
  if (!drag || drag.dropped) return;
  drag.now = moved(drag.from, drag.now, pose);
  memory.dragged = drag.now;
  const blended = blend(studio);
  studio.live("deform", "move_handle", {
    name: drag.name,
    move: drag.now,
    ...(blended && { blended: true }),
  });
  soon(studio);
}

/** The drag goes on only if it was not dropped. */
export async function endMoving(studio: Studio): Promise<void> {
  if (!drag) return;
  const { name, from, now, dropped } = drag;
  drag = null;
  if (!dropped && (!same(now.translation, from.translation) || !same(now.rotation, from.rotation)))
    await moveHandle(studio, name, now);
  else if (!dropped) studio.drop();
  memory.dragged = null;
  studio.changed();
}

/** Everything goes back to where it was before the drag. True if there was one. */
export function dropMoving(studio: Studio): boolean {
  if (!drag || drag.dropped) return false;
  drag.dropped = true;
  memory.dragged = null;
  studio.drop();
  soon(studio);
  return true;
}

export async function moveHandle(studio: Studio, name: string, to: Move): Promise<void> {
  if (!(await studio.do("deform", "move_handle", { name, move: to }))) studio.drop();
}

/** Puts the surface to where a pure translation brings it; false if the server has to. */
export function blend(studio: Studio): boolean {
  if (!drag?.basis || drag.dropped || !same(drag.now.rotation, drag.from.rotation)) return false;
  const surface = studio.viewports[0]!.surface("mesh");
  const { start, response } = drag.basis;
  if (surface?.positions.length !== start.length) return false;
  const { from, now } = drag;
  const by = now.translation.map((part, k) => part - from.translation[k]!);
  surface.blend(start, response, by);
  recolour(studio);
  return true;
}

/** The pose of a handle after the gizmo's; what the gizmo did not change stays to the digit. */
function moved(from: Move, before: Move, pose: Pose): Move {
  const rotation = pose.rotation.map((part) => part * degrees) as Vector;
  const wound = continued(before.rotation, rotation);
  const size = Math.max(...pose.translation.map(Math.abs), ...from.translation.map(Math.abs));
  return {
    translation: close(pose.translation, from.translation, 1e-9 * size)
      ? from.translation
      : (pose.translation.map(rounded) as Vector),
    rotation: close(wound, from.rotation, 1e-7) ? from.rotation : (wound.map(rounded) as Vector),
    scale: from.scale,
  };
}

/** To as many digits as a mouse can mean. */
const rounded = (value: number) => Number(value.toPrecision(9));

/**
 * The rotation vector, in degrees, of the same rotation that is nearest to the one before: going
 * round and round winds up.
 */
export function continued(before: Vector, rotation: Vector): Vector {
  const angle = Math.hypot(...rotation);
  const axis = angle > 1e-9 ? rotation.map((part) => part / angle) : unit(before);
  if (!axis) return rotation;
  const along = axis.reduce((sum, part, k) => sum + part * before[k]!, 0);
  const turns = Math.round((along - angle) / 360);
  return axis.map((part) => part * (angle + 360 * turns)) as Vector;
}

function unit(vector: Vector): number[] | null {
  const length = Math.hypot(...vector);
  return length > 1e-9 ? vector.map((part) => part / length) : null;
}
