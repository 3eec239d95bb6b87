/** A brush of a radius in space, which gathers vertices. */
import type { Drag } from "./pointer";
import type { Sight } from "./sight";
import type { SurfaceView } from "./surface";
import type { Hit } from "./types";
import { dot, pointAt, subtract, toLocal } from "./vectors";

/** Steps between two places of the pointer, and the milliseconds for them, at most. */
const STEPS = 24;
const BUDGET = 24;

/** What a brush needs of its viewport, and what it tells. */
export interface Painted {
  /** What is at a pixel of the viewport. */
  hit(x: number, y: number): Hit | null;
  surface(key: string): SurfaceView | undefined;
  sight(): Sight;
  radius(): number;
  /** Pixels of the radius where a hit is. */
  pixels(hit: Hit | null): number;
  /** The brush came to a pixel. */
  at(x: number, y: number, hit: Hit | null): void;
  /** Vertices touched so far, sorted. */
  touched(surface: SurfaceView, ids: Uint32Array, event: PointerEvent, done: boolean): void;
  cancelled(surface: SurfaceView): void;
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

/** A drag that paints on the surface where it starts, and along the way between two places. */
export class Stroke implements Drag {
  private readonly ids = new Set<number>();
  private spacing = 1;
  private cost = 0;

  private constructor(
    private readonly painted: Painted,
    private readonly surface: SurfaceView,
    private last: [number, number],
  ) {}

  /** A stroke that starts at a pixel; null if no surface is there. */
  static begin(painted: Painted, x: number, y: number, event: PointerEvent): Stroke | null {
    const surface = painted.surface(painted.hit(x, y)?.surface ?? "");
    if (!surface) return null;
    const stroke = new Stroke(painted, surface, [x, y]);
    stroke.move(x, y, event);
    return stroke;
  }

  move(x: number, y: number, event: PointerEvent): void {
    const [fromX, fromY] = this.last;
    const steps = this.steps(Math.hypot(x - fromX, y - fromY));
    const started = performance.now();
    for (let i = 1; i <= steps; i++) {
      this.touch(fromX + (i / steps) * (x - fromX), fromY + (i / steps) * (y - fromY));
    }
    this.cost = (performance.now() - started) / steps;
    this.last = [x, y];
    this.tell(event, false);
  }

  end(event: PointerEvent): void {
    this.tell(event, true);
  }

  cancel(): void {
    this.painted.cancelled(this.surface);
  }

  /** As many as are half a radius apart, if there is time. */
  private steps(way: number): number {
    const affordable = BUDGET / Math.max(this.cost, 0.1);
    return Math.max(1, Math.ceil(Math.min(STEPS, affordable, way / this.spacing)));
  }

  private touch(x: number, y: number): void {
    const { painted, surface } = this;
    const hit = painted.hit(x, y);
    if (hit?.surface === surface.key) {
      const found = dab(surface, hit, painted.radius(), painted.sight());
      for (const vertex of found) this.ids.add(vertex);
    }
    this.spacing = Math.max(1, painted.pixels(hit) / 2);
    painted.at(x, y, hit);
  }

  private tell(event: PointerEvent, done: boolean): void {
    this.painted.touched(this.surface, Uint32Array.from(this.ids).sort(), event, done);
  }
}
