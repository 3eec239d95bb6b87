/** A brush of a radius in space, which gathers vertices. */
import type { Drag } from "./pointer";
import type { Sight } from "./sight";
import type { SurfaceView } from "./surface";
import type { Hit } from "./types";
import { dot, pointAt, subtract, toLocal } from "./vectors";

/** Steps between two places of the pointer, and the milliseconds for them, at most. */
const STEPS = 24;
const BUDGET = 24;

/** What a brush needs of its viewport. */
export interface Painted {
  /** What is at a pixel of the viewport. */
  hit(x: number, y: number): Hit | null;
  surface(key: string): SurfaceView | undefined;
  sight(): Sight;
  radius(): number;
  /** Pixels of the radius where a hit is. */
  pixels(hit: Hit | null): number;
}

/** Vertices within a radius of a hit, connected to it, that face the eye. */
export function dab(surface: SurfaceView, hit: Hit, radius: number, sight: Sight): number[] {
  const { positions, data, placed } = surface;
  const centre = toLocal(data, hit.point);
  const within = (radius / data.scale) ** 2;
  const eye = sight.within(placed.factor, placed.shift).eye.position;
  return surface.adjacency.connected(hit.triangle, (vertex) => {
    const point = pointAt(positions, vertex);
    const apart = subtract(point, centre);
    return dot(apart, apart) <= within && dot(surface.normalAt(vertex), subtract(eye, point)) > 0;
  });
}

/**
 * A drag that paints on the surface where it starts, along the way between two places of the
 * pointer too.
 *
 * @param told of the surface's vertices touched so far, sorted; the event is given when done
 */
export function painting(
  painted: Painted,
  start: [number, number],
  told: (surface: SurfaceView, ids: Uint32Array, event: PointerEvent | null) => void,
  cancelled: (surface: SurfaceView) => void,
): Drag | null {
  const surface = painted.surface(painted.hit(...start)?.surface ?? "");
  if (!surface) return null;
  const touched = new Set<number>();
  let last = start;
  const touch = (x: number, y: number): number => {
    const hit = painted.hit(x, y);
    if (hit?.surface === surface.key && !hit.snapped) {
      const found = dab(surface, hit, painted.radius(), painted.sight());
      for (const vertex of found) touched.add(vertex);
    }
    return painted.pixels(hit);
  };
  let cost = 0;
  const sorted = () => Uint32Array.from(touched).sort();
  let spacing = touch(...start) / 2;
  told(surface, sorted(), null);
  return {
    move(x, y) {
      const way = Math.hypot(x - last[0], y - last[1]);
      const affordable = Math.min(STEPS, BUDGET / Math.max(cost, 0.1), way / Math.max(1, spacing));
      const steps = Math.max(1, Math.ceil(affordable));
      const started = performance.now();
      for (let i = 1; i <= steps; i++) {
        const t = i / steps;
        spacing = touch(last[0] + t * (x - last[0]), last[1] + t * (y - last[1])) / 2;
      }
      cost = (performance.now() - started) / steps;
      last = [x, y];
      told(surface, sorted(), null);
    },
    end: (event) => told(surface, sorted(), event),
    cancel: () => cancelled(surface),
  };
}
