/** Which vertex of a level is meant, and how a line follows one of its points. */

import type { Hit, Point, SurfaceView } from "../../viewer/index.ts";
import { add, dot, scaled, subtract } from "../../viewer/vectors.ts";

/**
 * The vertex of a coarser level that is nearest to a hit, over the surface and not through it.
 *
 * Vertices of a level keep their numbers at finer ones, so its own are the first `count`.
 *
 * @param rings of the surface's faces from one vertex of the level to the next
 */
export function nearestOfLevel(
  surface: SurfaceView,
  hit: Hit,
  count: number,
  rings: number,
): number {
  const { triangles } = surface.data;
  const seen = new Set(triangles.subarray(3 * hit.triangle, 3 * hit.triangle + 3));
  let rim: ArrayLike<number> = [...seen];
  let found = [...seen].filter((vertex) => vertex < count);
  for (let ring = 0; rim.length > 0 && (ring < rings || found.length === 0); ring++) {
    const next = surface.adjacency.around(rim).filter((vertex) => !seen.has(vertex));
    for (const vertex of next) {
      seen.add(vertex);
      if (vertex < count) found.push(vertex);
    }
    rim = next;
  }
  const apart = (vertex: number) => {
    const by = subtract(surface.vertexAt(vertex), hit.point);
    return dot(by, by);
  };
  return found.reduce((best, vertex) => (apart(vertex) < apart(best) ? vertex : best), found[0]!);
}

/**
 * A line of which one point is moved, and others the less the farther along they are.
 *
 * @param reach how far along its neighbours follow, as a part of the length
 */
export function pulled(line: readonly Point[], index: number, by: Point, reach: number): Point[] {
  const along = [0];
  for (let k = 1; k < line.length; k++) {
    along.push(along[k - 1]! + Math.hypot(...subtract(line[k]!, line[k - 1]!)));
  }
  const length = along.at(-1)!;
  const closed = line.length > 2 && line[0]!.every((x, k) => x === line.at(-1)![k]);
  return line.map((point, k) => {
    let apart = Math.abs(along[k]! - along[index]!);
    if (closed) apart = Math.min(apart, length - apart);
    const near = apart < reach * length;
    const share = near ? Math.cos((Math.PI * apart) / (reach * length)) / 2 + 0.5 : +(apart === 0);
    return add(point, scaled(by, share));
  });
}
