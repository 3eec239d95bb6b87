/** Normals of vertices: the sum over a vertex's triangles of normal times twice the area. */
import type { Adjacency } from "./adjacency";

/**
 * Normals (n, 3) of all vertices, not of unit length: their length tells the area around a vertex.
 */
export function allNormals(
  positions: Float32Array,
  triangles: Uint32Array,
  normals: Float32Array,
): void {
  normals.fill(0);
  for (let i = 0; i < triangles.length; i += 3) {
    const a = 3 * triangles[i]!;
    const b = 3 * triangles[i + 1]!;
    const c = 3 * triangles[i + 2]!;
    const px = positions[a]!;
    const py = positions[a + 1]!;
    const pz = positions[a + 2]!;
    const ux = positions[b]! - px;
    const uy = positions[b + 1]! - py;
    const uz = positions[b + 2]! - pz;
    const vx = positions[c]! - px;
    const vy = positions[c + 1]! - py;
    const vz = positions[c + 2]! - pz;
    const x = uy * vz - uz * vy;
    const y = uz * vx - ux * vz;
    const z = ux * vy - uy * vx;
    normals[a]! += x;
    normals[a + 1]! += y;
    normals[a + 2]! += z;
    normals[b]! += x;
    normals[b + 1]! += y;
    normals[b + 2]! += z;
    normals[c]! += x;
    normals[c + 1]! += y;
    normals[c + 2]! += z;
  }
}

/** The same for some vertices only. */
export function someNormals(
  positions: Float32Array,
  triangles: Uint32Array,
  adjacency: Adjacency,
  vertices: Uint32Array,
  normals: Float32Array,
): void {
  for (const vertex of vertices) {
    let [x, y, z] = [0, 0, 0];
    for (let k = adjacency.start[vertex]!; k < adjacency.start[vertex + 1]!; k++) {
      const i = 3 * adjacency.triangles[k]!;
      const a = 3 * triangles[i]!;
      const b = 3 * triangles[i + 1]!;
      const c = 3 * triangles[i + 2]!;
      const px = positions[a]!;
      const py = positions[a + 1]!;
      const pz = positions[a + 2]!;
      const ux = positions[b]! - px;
      const uy = positions[b + 1]! - py;
      const uz = positions[b + 2]! - pz;
      const vx = positions[c]! - px;
      const vy = positions[c + 1]! - py;
      const vz = positions[c + 2]! - pz;
      x += uy * vz - uz * vy;
      y += uz * vx - ux * vz;
      z += ux * vy - uy * vx;
    }
    normals[3 * vertex] = x;
    normals[3 * vertex + 1] = y;
    normals[3 * vertex + 2] = z;
  }
}
