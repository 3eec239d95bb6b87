/** Which points a surface hides from the eye, tested exactly, for all points in one pass. */
import type { Sight } from "./sight";
import type { Point } from "./types";
import { cross, dot, pointAt, subtract } from "./vectors";

export interface Sighted {
  /** In the surface's coordinates. */
  position: Point;
  /** The vertex that it is, whose own triangles hide nothing; -1 if it is none. */
  vertex: number;
}

/** Of a surface's size (1), up to which a triangle in front of a point is at it. */
const TOUCHING = { vertex: 1e-5, point: 4e-3 };

/** Pixels. */
const CELL = 24;

let projected = new Float64Array(0);

/** Sets `hidden[i]` to 1 for each point hidden by triangles (t, 3) of positions (n, 3). */
export function hide(
  positions: Float32Array,
  triangles: Uint32Array,
  sight: Sight,
  points: Sighted[],
  hidden: Uint8Array,
): void {
  if (projected.length < positions.length) projected = new Float64Array(positions.length);
  sight.projectAll(positions, projected);
  const grid = new Grid(sight, points);
  const eye = sight.eye.position;
  const test = (point: number, corners: number[]) => {
    const { position, vertex } = points[point]!;
    if (hidden[point] || corners.includes(vertex)) return;
    const touching = vertex < 0 ? TOUCHING.point : TOUCHING.vertex;
    const seen = corners.map((corner) => subtract(pointAt(positions, corner), eye));
    if (between(seen, subtract(position, eye), touching)) hidden[point] = 1;
  };
  for (let i = 0; i < triangles.length; i += 3) {
    const a = triangles[i]!;
    const b = triangles[i + 1]!;
    const c = triangles[i + 2]!;
    if (!grid.cover(projected, 3 * a, 3 * b, 3 * c)) continue;
    for (const point of grid.covered()) test(point, [a, b, c]);
  }
}

/** Whether a triangle, seen from the eye, lies before the end of a line by more than `touching`. */
function between(corners: Point[], line: Point, touching: number): boolean {
  const [a, b, c] = corners as [Point, Point, Point];
  const normal = cross(b, c);
  const u = dot(line, normal);
  const v = dot(line, cross(c, a));
  const w = dot(line, cross(a, b));
  if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) return false;
  const total = u + v + w;
  if (total === 0) return false;
  const share = dot(a, normal) / total;
  return share > 0 && share < 1 - touching / Math.sqrt(dot(line, line));
}

/** The points in each cell of the screen. */
class Grid {
  private readonly columns: number;
  private readonly rows: number;
  /** First point of each cell, and the one after each point; -1 for none. */
  private readonly first: Int32Array;
  private readonly after: Int32Array;
  /** Cells that the last triangle covers. */
  private left = 0;
  private right = 0;
  private top = 0;
  private bottom = 0;

  constructor(sight: Sight, points: Sighted[]) {
    this.columns = Math.max(1, Math.ceil(sight.width / CELL));
    this.rows = Math.max(1, Math.ceil(sight.height / CELL));
    this.first = new Int32Array(this.columns * this.rows).fill(-1);
    this.after = new Int32Array(points.length).fill(-1);
    points.forEach(({ position }, index) => {
      const [x, y, depth] = sight.project(position);
      if (!(depth > 0)) return;
      const cell = this.row(y) * this.columns + this.column(x);
      this.after[index] = this.first[cell]!;
      this.first[cell] = index;
    });
  }

  private column(x: number): number {
    return Math.max(0, Math.min(this.columns - 1, Math.floor(x / CELL)));
  }

  private row(y: number): number {
    return Math.max(0, Math.min(this.rows - 1, Math.floor(y / CELL)));
  }

  /** Finds the cells that a triangle covers; false if no point is in them. */
  cover(seen: Float64Array, a: number, b: number, c: number): boolean {
    const ahead = +(seen[a + 2]! > 0) + +(seen[b + 2]! > 0) + +(seen[c + 2]! > 0);
    if (ahead === 0) return false;
    if (ahead < 3) {
      this.left = this.top = 0;
      this.right = this.columns - 1;
      this.bottom = this.rows - 1;
      return true;
    }
    this.left = this.column(Math.min(seen[a]!, seen[b]!, seen[c]!));
    this.right = this.column(Math.max(seen[a]!, seen[b]!, seen[c]!));
    this.top = this.row(Math.min(seen[a + 1]!, seen[b + 1]!, seen[c + 1]!));
    this.bottom = this.row(Math.max(seen[a + 1]!, seen[b + 1]!, seen[c + 1]!));
    for (let row = this.top; row <= this.bottom; row++) {
      const start = row * this.columns;
      for (let cell = start + this.left; cell <= start + this.right; cell++) {
        if (this.first[cell]! >= 0) return true;
      }
    }
    return false;
  }

  /** The points in those cells. */
  *covered(): Generator<number> {
    for (let row = this.top; row <= this.bottom; row++) {
      for (let column = this.left; column <= this.right; column++) {
        let point = this.first[row * this.columns + column]!;
        for (; point >= 0; point = this.after[point]!) yield point;
      }
    }
  }
}
