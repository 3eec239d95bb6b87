/** The lines that are drawn over a surface, found from its triangles. */

import { cross, dot, pointAt, subtract } from "../viewer/vectors.ts";
import type { Point } from "../viewer/index.ts";

/** Edges of a crease, at least. */
const FEWEST = 8;

/** Length of a crease that does not close, at least; the surface's bounding box has diagonal 2. */
const LONG = 0.4;

/** Triangles from which on only boundaries are creases, to be quick. */
const MANY = 400_000;

/**
 * Edges (e, 2) of the faces, without the diagonals of polygons; and those on the boundary or
 * between faces that fold.
 *
 * @param positions (n, 3), normalised
 * @param triangles (t, 3)
 * @param face (t,) polygon of each triangle; undefined if triangles are the faces
 * @param fold degrees between two faces from which on they fold
 * @param thin height of a triangle up to which rounding may have turned it
 */
export function outlines(
  positions: Float32Array,
  triangles: Uint32Array,
  face: Uint32Array | undefined,
  fold: number,
  thin: number,
): { edges: Uint32Array; creases: Uint32Array } {
  const count = positions.length / 3;
  const total = triangles.length / 3;
  const { start, keys } = sides(triangles, count);
  const normals = total > MANY ? null : unitNormals(positions, triangles, thin);
  const least = Math.cos((fold * Math.PI) / 180);
  const edges = new Uint32Array(2 * triangles.length);
  const border: number[] = [];
  const sharp: number[] = [];
  let size = 0;
  for (let vertex = 0; vertex < count; vertex++) {
    for (let i = start[vertex]!, end = start[vertex + 1]!; i < end;) {
      const other = Math.floor(keys[i]! / total);
      let next = i + 1;
      while (next < end && Math.floor(keys[next]! / total) === other) next += 1;
      const [p, q] = [keys[i]! % total, keys[next - 1]! % total];
      const pair = next - i === 2;
      i = next;
      if (pair && face && face[p] === face[q]) continue;
      edges[size++] = vertex;
      edges[size++] = other;
      if (!pair) border.push(vertex, other);
      else if (normals && folded(normals, p, q, least)) sharp.push(vertex, other);
    }
  }
  const creases = Uint32Array.from(border.concat(lasting(sharp, positions)));
  return { edges: edges.slice(0, size), creases };
}

/**
 * The sides of all triangles by their lower vertex: `higher * t + triangle`, in order.
 *
 * Those of vertex v are from start[v] to start[v + 1].
 */
function sides(triangles: Uint32Array, count: number) {
  const total = triangles.length / 3;
  const start = new Uint32Array(count + 1);
  const keys = new Float64Array(triangles.length);
  const each = (visit: (low: number, high: number, triangle: number) => void) => {
    for (let i = 0; i < triangles.length; i++) {
      const a = triangles[i]!;
      const b = triangles[i % 3 === 2 ? i - 2 : i + 1]!;
      visit(Math.min(a, b), Math.max(a, b), Math.floor(i / 3));
    }
  };
  each((low) => (start[low + 1]! += 1));
  for (let vertex = 0; vertex < count; vertex++) start[vertex + 1]! += start[vertex]!;
  const next = start.slice(0, count);
  each((low, high, triangle) => (keys[next[low]!++] = high * total + triangle));
  for (let vertex = 0; vertex < count; vertex++)
    keys.subarray(start[vertex], start[vertex + 1]).sort();
  return { start, keys };
}

/** Unit normals (t, 3); 0 of triangles that are too thin to have one. */
function unitNormals(positions: Float32Array, triangles: Uint32Array, thin: number): Float32Array {
  const normals = new Float32Array(triangles.length);
  for (let i = 0; i < triangles.length; i += 3) {
    const [a, b, c] = [0, 1, 2].map((k) => pointAt(positions, triangles[i + k]!)) as [
      Point,
      Point,
      Point,
    ];
    const [u, v, w] = [subtract(b, a), subtract(c, a), subtract(c, b)];
    const normal = cross(u, v);
    const size = Math.sqrt(dot(normal, normal));
    const longest = Math.sqrt(Math.max(dot(u, u), dot(v, v), dot(w, w)));
    if (size > thin * longest) for (let k = 0; k < 3; k++) normals[i + k] = normal[k]! / size;
  }
  return normals;
}

function folded(normals: Float32Array, p: number, q: number, least: number): boolean {
  const [a, b] = [pointAt(normals, p), pointAt(normals, q)];
  return dot(a, a) > 0 && dot(b, b) > 0 && dot(a, b) < least;
}

/**
 * Those of some edges that hang together in some number, and either close or are long: others are
 * noise of a scan.
 */
function lasting(edges: number[], positions: Float32Array): number[] {
  const count = positions.length / 3;
  const root = Uint32Array.from({ length: count }, (_, vertex) => vertex);
  const find = (vertex: number): number => {
    while (root[vertex] !== vertex) vertex = root[vertex] = root[root[vertex]!]!;
    return vertex;
  };
  const closed = new Uint8Array(count);
  for (let i = 0; i < edges.length; i += 2) {
    const [a, b] = [find(edges[i]!), find(edges[i + 1]!)];
    root[a] = b;
    closed[b]! |= closed[a]! | Number(a === b);
  }
  const sizes = new Uint32Array(count);
  const lengths = new Float64Array(count);
  for (let i = 0; i < edges.length; i += 2) {
    const whole = find(edges[i]!);
    const way = subtract(pointAt(positions, edges[i]!), pointAt(positions, edges[i + 1]!));
    sizes[whole]! += 1;
    lengths[whole]! += Math.sqrt(dot(way, way));
  }
  const lasts = (whole: number) =>
    sizes[whole]! >= FEWEST && (closed[whole] === 1 || lengths[whole]! >= LONG);
  return edges.filter((vertex) => lasts(find(vertex)));
}
