/** The shapes between a and b, made here: no bytes are sent while the morph is scrubbed. */

import type { Point, SurfaceView, Viewport } from "../../viewer/index.ts";
import { subtract } from "../../viewer/vectors.ts";

export interface Way {
  /** (n, 3), at 0 and at 1. */
  a: Float32Array;
  b: Float32Array;
  /** (k + 3, n, 3) at the multiples of 1 / k, from one before 0 to one after 1; null: straight. */
  knots: Float32Array | null;
  /** (n,) when each vertex starts; null: all at once. */
  delay: Float32Array | null;
  /** At rest at both ends. */
  eased: boolean;
}

const ease = (t: number) => t * t * (3 - 2 * t);

/** Brings a surface to time `t` in [0, 1]. */
export function bringTo(view: SurfaceView, way: Way, t: number): void {
  const s = way.eased ? ease(t) : t;
  if (!way.knots && !way.delay) view.morph(way.a, way.b, s);
  else view.setPositions(positionsAt(way, t));
}

/** Looks at the middle of the shape at time `t`, from as far as those at both ends need. */
export function fitAll(viewport: Viewport, surface: SurfaceView, way: Way, t: number): void {
  const { pose } = viewport;
  const looks = [0, 1, t].map((time) => {
    bringTo(surface, way, time);
    viewport.frame();
    return { target: pose.target, distance: pose.distance };
  });
  const { target } = looks.at(-1)!;
  const aside = (to: Point) => Math.hypot(...subtract(to, target));
  pose.fit(target, Math.max(...looks.map((look) => look.distance + aside(look.target))));
  viewport.turned();
}

/** Positions (n, 3) at time `t` in [0, 1]. */
export function positionsAt(way: Way, t: number): Float32Array {
  const count = way.a.length / 3;
  const times = way.delay ? localTimes(way.delay, t, way.eased) : null;
  const whole = way.eased ? ease(t) : t;
  const found = new Float32Array(way.a.length);
  const time = (vertex: number) => (times ? times[vertex]! : whole);
  if (way.knots) turned(way.knots, count, time, found);
  else straight(way.a, way.b, time, found);
  return found;
}

/** Each vertex's own time: all take equally long, and the last arrive at 1. */
function localTimes(delay: Float32Array, t: number, eased: boolean): Float32Array {
  const window = 1 - delay.reduce((most, value) => Math.max(most, value), 0);
  return delay.map((start) => {
    const own = t === 1 ? 1 : Math.min(Math.max((t - start) / window, 0), 1);
    return eased ? ease(own) : own;
  });
}

type Time = (vertex: number) => number;

function straight(a: Float32Array, b: Float32Array, time: Time, found: Float32Array): void {
  for (let vertex = 0, i = 0; i < found.length; vertex++) {
    const t = time(vertex);
    for (const end = i + 3; i < end; i++) found[i] = (1 - t) * a[i]! + t * b[i]!;
  }
}

/** Between knots by the cubic through the four around. */
function turned(knots: Float32Array, count: number, time: Time, found: Float32Array): void {
  const size = 3 * count;
  const intervals = knots.length / size - 3;
  for (let vertex = 0, i = 0; vertex < count; vertex++) {
    const place = time(vertex) * intervals;
    const start = Math.min(Math.floor(place), intervals - 1);
    const u = place - start;
    const before = (u * (1 - u) * (u - 2)) / 6;
    const first = ((u + 1) * (u - 1) * (u - 2)) / 2;
    const second = (u * (u + 1) * (2 - u)) / 2;
    const after = ((u - 1) * u * (u + 1)) / 6;
    let k = start * size + i;
    for (const end = i + 3; i < end; i++, k++)
      found[i] =
        before * knots[k]! +
        first * knots[k + size]! +
        second * knots[k + 2 * size]! +
        after * knots[k + 3 * size]!;
  }
}
