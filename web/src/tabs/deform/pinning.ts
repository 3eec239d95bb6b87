/** Dragging a pin by its mark, in the plane of the screen. */

import type { Vector } from "../../ui/index.ts";
import type { View, Viewport } from "../../viewer/index.ts";
import type { Studio } from "../tab.ts";
import { memory, viewOf } from "./memory.ts";
import { pinMark } from "./selecting.ts";
import type { PinPart } from "./types.ts";

interface Drag {
  pin: PinPart;
  pointer: number;
  from: [number, number];
  /** In space, for a pixel to the right and one downward. */
  right: number[];
  down: number[];
  to: Vector;
  moved: boolean;
}

const steady = 3; // pixels that a click may move

let drag: Drag | null = null;

/** Everything goes back to where it was before the drag. True if there was one. */
export function dropPinning(studio: Studio): boolean {
  if (!drag) return false;
  drag = null;
  studio.drop();
  return true;
}

/** Lets pins be dragged in a viewport; what it returns ends that. */
export function letPinsBeDragged(studio: Studio, viewport: Viewport): () => void {
  const { element } = viewport;
  const ended = new AbortController();
  const listen = (
    name: "pointerdown" | "pointermove" | "pointerup",
    on: (e: PointerEvent) => void,
  ) => element.addEventListener(name, on, { capture: true, signal: ended.signal });
  listen("pointerdown", (event) => {
    drag = begun(studio, viewport, event);
    if (!drag) return;
    event.stopImmediatePropagation();
    element.setPointerCapture(event.pointerId);
  });
  listen("pointermove", (event) => {
    if (event.pointerId !== drag?.pointer) return;
    event.stopImmediatePropagation();
    const { pin, from, right, down } = drag;
    const [x, y] = [event.clientX - from[0], event.clientY - from[1]];
    drag.moved ||= Math.hypot(x, y) >= steady;
    if (!drag.moved) return;
    drag.to = pin.to.map((at, k) => at + x * right[k]! + y * down[k]!) as Vector;
    studio.live("deform", "move_pin", { name: pin.name, to: drag.to });
  });
  listen("pointerup", (event) => {
    if (event.pointerId !== drag?.pointer) return;
    event.stopImmediatePropagation();
    const { pin, to, moved } = drag;
    drag = null;
    if (moved) void movePin(studio, pin.name, to);
    memory.part = { kind: "pins", name: pin.name };
    studio.changed();
  });
  return () => ended.abort();
}

export async function movePin(studio: Studio, name: string, to: Vector): Promise<void> {
  if (!(await studio.do("deform", "move_pin", { name, to }))) studio.drop();
}

function begun(studio: Studio, viewport: Viewport, event: PointerEvent): Drag | null {
  if (event.button !== 0 || event.altKey || viewport.gizmo.busy) return null;
  const { left, top, height } = viewport.element.getBoundingClientRect();
  const mark = viewport.marks.at(event.clientX - left, event.clientY - top);
  if (!mark?.startsWith(pinMark)) return null;
  const name = mark.slice(pinMark.length);
  const pin = viewOf(studio)?.parts?.find((part) => part.kind === "pins" && part.name === name);
  if (pin?.kind !== "pins") return null;
  const { right, down } = pixelAt(viewport.camera(), pin.to, height);
  const from: [number, number] = [event.clientX, event.clientY];
  return { pin, pointer: event.pointerId, from, right, down, to: pin.to, moved: false };
}

/** What a pixel to the right and one downward are in space, at the depth of a point. */
export function pixelAt(
  camera: View,
  point: Vector,
  height: number,
): { right: number[]; down: number[] } {
  const ahead = unit(camera.target.map((part, k) => part - camera.position[k]!));
  const across = unit(cross(ahead, camera.up));
  const up = cross(across, ahead);
  const depth = ahead.reduce((sum, part, k) => sum + part * (point[k]! - camera.position[k]!), 0);
  const slope = Math.tan((camera.field_of_view * Math.PI) / 360);
  const size = (2 * slope * depth) / height;
  return { right: across.map((part) => part * size), down: up.map((part) => -part * size) };
}

function unit(vector: readonly number[]): number[] {
  const length = Math.hypot(...vector);
  return vector.map((part) => part / length);
}

function cross(a: readonly number[], b: readonly number[]): number[] {
  return [
    a[1]! * b[2]! - a[2]! * b[1]!,
    a[2]! * b[0]! - a[0]! * b[2]!,
    a[0]! * b[1]! - a[1]! * b[0]!,
  ];
}
