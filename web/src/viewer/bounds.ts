/** The box around a surface's vertices. */
import type { Point } from "./types";

export class Bounds {
  low: Point = [Infinity, Infinity, Infinity];
  high: Point = [-Infinity, -Infinity, -Infinity];

  /** The box of all positions (n, 3) that are used by a face. */
  static around(positions: Float32Array, used: Uint8Array): Bounds {
    const bounds = new Bounds();
    let [x0, y0, z0] = bounds.low;
    let [x1, y1, z1] = bounds.high;
    for (let vertex = 0, i = 0; vertex < used.length; vertex++, i += 3) {
      if (!used[vertex]) continue;
      const x = positions[i]!;
      const y = positions[i + 1]!;
      const z = positions[i + 2]!;
      if (x < x0) x0 = x;
      if (x > x1) x1 = x;
      if (y < y0) y0 = y;
      if (y > y1) y1 = y;
      if (z < z0) z0 = z;
      if (z > z1) z1 = z;
    }
    bounds.low = [x0, y0, z0];
    bounds.high = [x1, y1, z1];
    return bounds;
  }

  get empty(): boolean {
    return !(this.low[0] <= this.high[0]);
  }

  add(x: number, y: number, z: number): void {
    const { low, high } = this;
    this.low = [Math.min(low[0], x), Math.min(low[1], y), Math.min(low[2], z)];
    this.high = [Math.max(high[0], x), Math.max(high[1], y), Math.max(high[2], z)];
  }

  /** Grows to hold another box whose points are placed at `shift + factor * point`. */
  join(other: Bounds, factor: number, shift: Point): void {
    if (other.empty) return;
    for (const [x, y, z] of [other.low, other.high]) {
      this.add(shift[0] + factor * x, shift[1] + factor * y, shift[2] + factor * z);
    }
  }

  get centre(): Point {
    const { low, high } = this;
    return [(low[0] + high[0]) / 2, (low[1] + high[1]) / 2, (low[2] + high[2]) / 2];
  }

  /** Half the diagonal. */
  get radius(): number {
    const { low, high } = this;
    return Math.hypot(high[0] - low[0], high[1] - low[1], high[2] - low[2]) / 2;
  }
}
