/** The vertex that is meant at a pixel, where only some vertices may be. */

import type { Viewport } from "../../viewer/index.ts";

/** Vertices that are tried until one is not hidden, the nearest first. */
const tried = 24;

/** Of its distance from the eye, by which a vertex may be behind what is seen at its place. */
const slack = 2e-3;

/**
 * Of the vertices `ids` of a surface, the visible one that is seen nearest to a pixel of the page;
 * the nearest of all where none of those near by is visible.
 *
 * @param reach pixels that it may be away
 */
export function nearestSeen(
  viewport: Viewport,
  key: string,
  ids: ArrayLike<number>,
  x: number,
  y: number,
  reach = Infinity,
): number | null {
  if (!viewport.surface(key)) return null;
  const found: { vertex: number; apart: number; at: [number, number] }[] = [];
  for (let i = 0; i < ids.length; i++) {
    const at = viewport.project(key, ids[i]!);
    const apart = Math.hypot(at[0] - x, at[1] - y);
    if (apart <= reach) found.push({ vertex: ids[i]!, apart, at });
  }
  found.sort((p, q) => p.apart - q.apart);
  const seen = found.slice(0, tried).find(({ vertex, at }) => isSeen(viewport, key, vertex, at));
  return (seen ?? found[0])?.vertex ?? null;
}

/** Whether nothing is before a vertex that is at a pixel of the page. */
function isSeen(viewport: Viewport, key: string, vertex: number, at: [number, number]): boolean {
  const hit = viewport.pick(...at);
  if (!hit || hit.snapped || (hit.surface === key && hit.vertex === vertex)) return true;
  const { position } = viewport.camera();
  const away = (point: ArrayLike<number>) =>
    Math.hypot(...position.map((value, k) => value - point[k]!));
  return away(viewport.surface(key)!.vertexAt(vertex)) <= (1 + slack) * away(hit.point);
}
