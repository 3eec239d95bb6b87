/** What is seen of several surfaces: the one under a pixel, and the points that they hide. */
import { hide, type Sighted } from "./occlusion";
import { firstMeeting, nearestCorner, verticesNear, type Meeting } from "./picking";
import type { Sight } from "./sight";
import type { SurfaceView } from "./surface";
import type { Anchor, Hit, Point } from "./types";
import { add, pointAt, scaled, toLocal, toWorld, type Frame } from "./vectors";

/** Vertices beside the surface that are tried, the nearest first. */
const TRIED = 32;

/**
 * What a pixel of the viewport shows of the solid surfaces, null for none.
 *
 * @param snap pixels beside a surface within which its nearest visible vertex is meant
 */
export function hitAt(
  surfaces: readonly SurfaceView[],
  sight: Sight,
  x: number,
  y: number,
  snap: number,
): Hit | null {
  let nearest: { surface: SurfaceView; meeting: Meeting; depth: number } | null = null;
  for (const surface of surfaces) {
    const { factor, shift } = surface.placed;
    const ray = sight.within(factor, shift).ray(x, y);
    const meeting = firstMeeting(surface.positions, surface.data.triangles, ray);
    if (!meeting) continue;
    const depth = meeting.distance * factor;
    if (!nearest || depth < nearest.depth) nearest = { surface, meeting, depth };
  }
  if (nearest) return met(nearest.surface, nearest.meeting, sight, x, y);
  return snap > 0 ? beside(surfaces, sight, x, y, snap) : null;
}

function met(surface: SurfaceView, meeting: Meeting, sight: Sight, x: number, y: number): Hit {
  const { positions, data, placed } = surface;
  const { triangle, barycentric } = meeting;
  const own = sight.within(placed.factor, placed.shift);
  const corners = [0, 1, 2].map((i) => pointAt(positions, data.triangles[3 * triangle + i]!));
  const local = corners
    .map((corner, i) => scaled(corner, barycentric[i]!))
    .reduce((sum, part) => add(sum, part));
  return {
    surface: surface.key,
    vertex: nearestCorner(positions, data.triangles, data.face, triangle, own, x, y),
    face: data.face ? data.face[triangle]! : triangle,
    triangle,
    barycentric,
    point: toWorld(data, local),
    snapped: false,
  };
}

/** The visible vertex nearest to a pixel that shows no surface. */
function beside(
  surfaces: readonly SurfaceView[],
  sight: Sight,
  x: number,
  y: number,
  snap: number,
): Hit | null {
  const found = surfaces.flatMap((surface) => {
    const own = sight.within(surface.placed.factor, surface.placed.shift);
    const near = verticesNear(surface.positions, surface.used, own, x, y, snap);
    return near.slice(0, TRIED).map(({ vertex, apart }) => ({ surface, vertex, apart }));
  });
  for (const { surface, vertex } of found.sort((p, q) => p.apart - q.apart).slice(0, TRIED)) {
    const [hidden] = hiddenBy(surfaces, sight, [{ surface: surface.key, vertex }], surface.data);
    if (!hidden) return snapped(surface, vertex);
  }
  return null;
}

function snapped(surface: SurfaceView, vertex: number): Hit {
  const { adjacency, data } = surface;
  const triangle = adjacency.triangles[adjacency.start[vertex]!]!;
  const weight = (i: number) => (data.triangles[3 * triangle + i] === vertex ? 1 : 0);
  return {
    surface: surface.key,
    vertex,
    face: data.face ? data.face[triangle]! : triangle,
    triangle,
    barycentric: [weight(0), weight(1), weight(2)],
    point: surface.vertexAt(vertex),
    snapped: true,
  };
}

/** Where an anchor is, in the coordinates of `frame`; null if its surface is not there. */
export function anchored(
  anchor: Anchor,
  surfaces: readonly SurfaceView[],
  frame: Frame,
): Point | null {
  if (!("surface" in anchor)) return toLocal(frame, [anchor[0]!, anchor[1]!, anchor[2]!]);
  const surface = surfaces.find(({ key }) => key === anchor.surface);
  if (!surface || !(anchor.vertex < surface.count)) return null;
  const { factor, shift } = surface.placed;
  return add(shift, scaled(pointAt(surface.positions, anchor.vertex), factor));
}

/** Which anchors are behind one of the surfaces, or nowhere; 1 for hidden. */
export function hiddenBy(
  surfaces: readonly SurfaceView[],
  sight: Sight,
  anchors: readonly Anchor[],
  frame: Frame,
): Uint8Array {
  const hidden = new Uint8Array(anchors.length);
  for (const surface of surfaces) {
    const points = anchors.map((anchor) => sighted(anchor, surface, surfaces, frame));
    const own = sight.within(surface.placed.factor, surface.placed.shift);
    hide(surface.positions, surface.data.triangles, own, points, hidden);
  }
  return hidden;
}

function sighted(
  anchor: Anchor,
  surface: SurfaceView,
  surfaces: readonly SurfaceView[],
  frame: Frame,
): Sighted {
  if ("surface" in anchor && anchor.surface === surface.key) {
    return { position: pointAt(surface.positions, anchor.vertex), vertex: anchor.vertex };
  }
  const { factor, shift } = surface.placed;
  const scene = anchored(anchor, surfaces, frame) ?? [NaN, NaN, NaN];
  return { position: scaled(add(scene, scaled(shift, -1)), 1 / factor), vertex: -1 };
}
