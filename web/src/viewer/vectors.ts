/** Points and frames in double precision. */
import type { Point } from "./types";

export const dot = (a: Point, b: Point): number => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];

export const add = (a: Point, b: Point): Point => [a[0] + b[0], a[1] + b[1], a[2] + b[2]];

export const subtract = (a: Point, b: Point): Point => [a[0] - b[0], a[1] - b[1], a[2] - b[2]];

export const scaled = (a: Point, by: number): Point => [a[0] * by, a[1] * by, a[2] * by];

export const cross = (a: Point, b: Point): Point => [
  a[1] * b[2] - a[2] * b[1],
  a[2] * b[0] - a[0] * b[2],
  a[0] * b[1] - a[1] * b[0],
];

/** Point number `index` of (n, 3) positions. */
export const pointAt = (positions: ArrayLike<number>, index: number): Point => [
  positions[3 * index]!,
  positions[3 * index + 1]!,
  positions[3 * index + 2]!,
];

/** Local coordinates: in space, a local point is at `centre + scale * point`. */
export interface Frame {
  centre: Point;
  scale: number;
}

export const toWorld = (frame: Frame, local: Point): Point =>
  add(frame.centre, scaled(local, frame.scale));

export const toLocal = (frame: Frame, world: Point): Point =>
  scaled(subtract(world, frame.centre), 1 / frame.scale);

/** The factor and shift that take local points of one frame to another's. */
export function between(from: Frame, to: Frame): { factor: number; shift: Point } {
  return {
    factor: from.scale / to.scale,
    shift: scaled(subtract(from.centre, to.centre), 1 / to.scale),
  };
}

/** Whether what fits one frame is well seen in the other. */
export function alike(a: Frame, b: Frame): boolean {
  const ratio = a.scale / b.scale;
  const apart = subtract(a.centre, b.centre);
  return ratio > 0.5 && ratio < 2 && Math.sqrt(dot(apart, apart)) < 0.5 * b.scale;
}
