/** Tubes along edges and beads at vertices, as surfaces that lie over another one. */

import type { SurfaceData } from "../../viewer/index.ts";

/** Of a quad's edge: radius of beads and of tubes. */
const beadSize = 0.24;
const tubeSize = 0.055;

/** Of half the diagonal of the surface: radii at least, to be seen from afar, and at most. */
const leastBead = 0.004;
const mostBead = 0.012;
const leastTube = 0.0013;

const sides = 5; // of a tube

/** A tube along each edge (k, 2). */
export function tubes(surface: SurfaceData, edges: Uint32Array): SurfaceData {
  const { positions } = surface;
  const count = edges.length / 2;
  const places = new Float32Array(count * 2 * sides * 3);
  const triangles = new Uint32Array(count * 2 * sides * 3);
  const radius = Math.max(leastTube, tubeSize * meanLength(positions, edges));
  for (let k = 0; k < count; k++) {
    const [a, b] = [3 * edges[2 * k]!, 3 * edges[2 * k + 1]!];
    const way = difference(positions, b, a);
    const length = Math.hypot(...way) || 1;
    const [x, y] = across(way.map((part) => part / length) as Vector);
    const first = 2 * sides * k;
    for (let end = 0; end < 2; end++) {
      const reach = (end === 0 ? -0.5 : 0.5) * radius; // so that tubes meet at corners
      for (let side = 0; side < sides; side++) {
        const angle = (2 * Math.PI * side) / sides;
        const [c, s] = [radius * Math.cos(angle), radius * Math.sin(angle)];
        const to = 3 * (first + sides * end + side);
        for (let axis = 0; axis < 3; axis++) {
          const from = positions[(end === 0 ? a : b) + axis]!;
          places[to + axis] = from + c * x[axis]! + s * y[axis]! + (reach * way[axis]!) / length;
        }
      }
    }
    for (let side = 0; side < sides; side++) {
      const next = (side + 1) % sides;
      const [p, q, r, t] = [side, next, sides + next, sides + side].map((v) => first + v);
      triangles.set([p!, q!, r!, p!, r!, t!], 6 * (sides * k + side));
    }
  }
  return over(surface, places, triangles);
}

/** Corners and faces of an icosahedron of radius 1. */
const [corners, faces] = icosahedron();

/** A bead at each of some vertices, as large as the edges there; and the vertex of each corner. */
export function beads(
  surface: SurfaceData,
  vertices: Uint32Array,
): { data: SurfaceData; corners: number } {
  const { positions, edges } = surface;
  const lengths = lengthsAt(positions, edges);
  const each = corners.length / 3;
  const places = new Float32Array(vertices.length * corners.length);
  const triangles = new Uint32Array(vertices.length * faces.length);
  vertices.forEach((vertex, k) => {
    const radius = Math.min(mostBead, Math.max(leastBead, beadSize * lengths[vertex]!));
    for (let i = 0; i < corners.length; i++)
      places[k * corners.length + i] = positions[3 * vertex + (i % 3)]! + radius * corners[i]!;
    for (let i = 0; i < faces.length; i++) triangles[k * faces.length + i] = k * each + faces[i]!;
  });
  return { data: over(surface, places, triangles), corners: each };
}

/** A rectangle in a plane, as large as a surface that it passes through. */
export function sheet(
  surface: SurfaceData,
  [point, normal]: readonly [readonly number[], readonly number[]],
): SurfaceData {
  const { centre, scale } = surface;
  const middle = point.map((part, axis) => (part - centre[axis]!) / scale);
  const size = Math.hypot(...normal) || 1;
  const [x, y] = across(normal.map((part) => part / size) as Vector);
  const places = [
    [-1, -1],
    [1, -1],
    [1, 1],
    [-1, 1],
  ].flatMap(([s, t]) => middle.map((m, axis) => m + 0.7 * (s! * x[axis]! + t! * y[axis]!)));
  const edges = new Uint32Array([0, 1, 1, 2, 2, 3, 3, 0]);
  const triangles = new Uint32Array([0, 1, 2, 0, 2, 3]);
  return { ...over(surface, new Float32Array(places), triangles), creases: edges };
}

function over(surface: SurfaceData, positions: Float32Array, triangles: Uint32Array): SurfaceData {
  const { centre, scale } = surface;
  return { positions, triangles, edges: new Uint32Array(0), centre, scale };
}

type Vector = [number, number, number];

function difference(positions: Float32Array, to: number, from: number): Vector {
  return [0, 1, 2].map((axis) => positions[to + axis]! - positions[from + axis]!) as Vector;
}

/** Two directions across one of length 1, and across each other. */
function across([a, b, c]: Vector): [Vector, Vector] {
  const least = [Math.abs(a), Math.abs(b), Math.abs(c)];
  const axis = least.indexOf(Math.min(...least));
  const [p, q, r] = [0, 1, 2].map((k) => (k === axis ? 1 : 0)) as Vector;
  const x: Vector = [b * r - c * q, c * p - a * r, a * q - b * p];
  const size = Math.hypot(...x) || 1;
  const [d, e, f] = x.map((part) => part / size) as Vector;
  return [
    [d, e, f],
    [b * f - c * e, c * d - a * f, a * e - b * d],
  ];
}

function meanLength(positions: Float32Array, edges: Uint32Array): number {
  let sum = 0;
  for (let k = 0; k < edges.length; k += 2)
    sum += Math.hypot(...difference(positions, 3 * edges[k + 1]!, 3 * edges[k]!));
  return sum / Math.max(1, edges.length / 2);
}

/** (n,) mean length of the edges at each vertex. */
function lengthsAt(positions: Float32Array, edges: Uint32Array): Float32Array {
  const sums = new Float32Array(positions.length / 3);
  const counts = new Float32Array(positions.length / 3);
  for (let k = 0; k < edges.length; k += 2) {
    const [a, b] = [edges[k]!, edges[k + 1]!];
    const length = Math.hypot(...difference(positions, 3 * b, 3 * a));
    for (const end of [a, b]) {
      sums[end]! += length;
      counts[end]! += 1;
    }
  }
  return sums.map((sum, vertex) => sum / Math.max(1, counts[vertex]!));
}

function icosahedron(): [number[], number[]] {
  const golden = (1 + Math.sqrt(5)) / 2;
  const size = Math.hypot(1, golden);
  const [s, l] = [1 / size, golden / size];
  // prettier-ignore
  const corners = [
    [-s, l, 0], [s, l, 0], [-s, -l, 0], [s, -l, 0],
    [0, -s, l], [0, s, l], [0, -s, -l], [0, s, -l],
    [l, 0, -s], [l, 0, s], [-l, 0, -s], [-l, 0, s],
  ];
  // prettier-ignore
  const faces = [
    [0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11],
    [1, 5, 9], [5, 11, 4], [11, 10, 2], [10, 7, 6], [7, 1, 8],
    [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8], [3, 8, 9],
    [4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1],
  ];
  return [corners.flat(), faces.flat()];
}
