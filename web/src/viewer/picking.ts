/** The first triangle that a ray meets, and the vertex that was meant. */
import type { Ray, Sight } from "./sight";
import type { Point } from "./types";
import { pointAt } from "./vectors";

export interface Meeting {
  triangle: number;
  /** In lengths of the ray's direction. */
  distance: number;
  barycentric: Point;
}

/**
 * The first triangle (t, 3) of positions (n, 3) that a ray meets, from either side.
 *
 * No ray slips between two neighbours: the value of an edge is the very opposite for the triangle
 * beyond it. After Woop, Benthin and Wald, Watertight Ray/Triangle Intersection (2013).
 */
export function firstMeeting(
  positions: Float32Array,
  triangles: Uint32Array,
  ray: Ray,
): Meeting | null {
  const [kx, ky, kz] = axes(ray.direction);
  const [ox, oy, oz] = [ray.origin[kx], ray.origin[ky], ray.origin[kz]];
  const along = 1 / ray.direction[kz];
  const [sx, sy] = [ray.direction[kx] * along, ray.direction[ky] * along];
  let found = -1;
  let nearest = Infinity;
  for (let i = 0; i < triangles.length; i += 3) {
    const a = 3 * triangles[i]!;
    const b = 3 * triangles[i + 1]!;
    const c = 3 * triangles[i + 2]!;
    const az = positions[a + kz]! - oz;
    const bz = positions[b + kz]! - oz;
    const cz = positions[c + kz]! - oz;
    const ax = positions[a + kx]! - ox - sx * az;
    const bx = positions[b + kx]! - ox - sx * bz;
    const cx = positions[c + kx]! - ox - sx * cz;
    const ay = positions[a + ky]! - oy - sy * az;
    const by = positions[b + ky]! - oy - sy * bz;
    const cy = positions[c + ky]! - oy - sy * cz;
    const u = cx * by - cy * bx;
    const v = ax * cy - ay * cx;
    if ((u < 0 && v > 0) || (u > 0 && v < 0)) continue;
    const w = bx * ay - by * ax;
    if ((u < 0 || v < 0 || w < 0) && (u > 0 || v > 0 || w > 0)) continue;
    const total = u + v + w;
    if (total === 0) continue;
    const distance = ((u * az + v * bz + w * cz) / total) * along;
    if (distance > 0 && distance < nearest) {
      nearest = distance;
      found = i / 3;
    }
  }
  if (found < 0) return null;
  return {
    triangle: found,
    distance: nearest,
    barycentric: weights(positions, triangles, ray, found),
  };
}

/** The axes of space, that of the ray's largest component last. */
function axes(direction: Point): [number, number, number] {
  const size = direction.map(Math.abs);
  const kz = size.indexOf(Math.max(...size));
  return [(kz + 1) % 3, (kz + 2) % 3, kz];
}

/** Weights of a triangle's corners where a ray meets it. */
function weights(
  positions: Float32Array,
  triangles: Uint32Array,
  ray: Ray,
  triangle: number,
): Point {
  const [kx, ky, kz] = axes(ray.direction);
  const corners = [0, 1, 2].map((i) => {
    const point = pointAt(positions, triangles[3 * triangle + i]!);
    const ahead = (point[kz] - ray.origin[kz]) / ray.direction[kz];
    return [kx, ky].map((k) => point[k]! - ray.origin[k]! - ray.direction[k]! * ahead);
  });
  const areas = [0, 1, 2].map((i) => {
    const [p, q] = [corners[(i + 1) % 3]!, corners[(i + 2) % 3]!];
    return q[0]! * p[1]! - q[1]! * p[0]!;
  });
  const total = areas[0]! + areas[1]! + areas[2]!;
  return [areas[0]! / total, areas[1]! / total, areas[2]! / total];
}

/** The corner of a triangle, or of the polygon it is part of, nearest to a pixel on the screen. */
export function nearestCorner(
  positions: Float32Array,
  triangles: Uint32Array,
  face: Uint32Array | undefined,
  triangle: number,
  sight: Sight,
  x: number,
  y: number,
): number {
  let nearest = triangles[3 * triangle]!;
  let least = Infinity;
  const look = (first: number) => {
    for (let i = first; i < first + 3; i++) {
      const vertex = triangles[i]!;
      const [px, py] = sight.project(pointAt(positions, vertex));
      const apart = (px - x) ** 2 + (py - y) ** 2;
      if (apart < least || (apart === least && vertex < nearest)) {
        least = apart;
        nearest = vertex;
      }
    }
  };
  if (!face) look(3 * triangle);
  else {
    const polygon = face[triangle]!;
    for (let i = 0; i < face.length; i++) if (face[i] === polygon) look(3 * i);
  }
  return nearest;
}

/** Vertices within some pixels of a pixel, the nearest first; `used` tells which are of a face. */
export function verticesNear(
  positions: Float32Array,
  used: Uint8Array,
  sight: Sight,
  x: number,
  y: number,
  within: number,
): { vertex: number; apart: number }[] {
  const [ex, ey, ez] = sight.eye.position;
  const [rx, ry, rz] = sight.eye.right;
  const [ux, uy, uz] = sight.eye.up;
  const [ax, ay, az] = sight.eye.ahead;
  const { focal } = sight;
  const [left, top] = [x - sight.width / 2, sight.height / 2 - y];
  const found: { vertex: number; apart: number }[] = [];
  for (let i = 0; i < positions.length; i += 3) {
    const dx = positions[i]! - ex;
    const dy = positions[i + 1]! - ey;
    const dz = positions[i + 2]! - ez;
    const depth = dx * ax + dy * ay + dz * az;
    if (!(depth > 0)) continue;
    const across = ((dx * rx + dy * ry + dz * rz) * focal) / depth - left;
    if (across > within || across < -within) continue;
    const upward = ((dx * ux + dy * uy + dz * uz) * focal) / depth - top;
    const apart = Math.sqrt(across * across + upward * upward);
    if (apart <= within && used[i / 3]) found.push({ vertex: i / 3, apart });
  }
  return found.sort((p, q) => p.apart - q.apart || p.vertex - q.vertex);
}
