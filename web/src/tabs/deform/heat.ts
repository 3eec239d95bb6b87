/** Colours by how far vertices moved, or how much the edges around them were stretched. */

import type { Studio } from "../tab.ts";
import type { SurfaceData, SurfaceView } from "../../viewer/index.ts";
import { memory } from "./memory.ts";

/** Vertices up to which colours follow every frame; on larger surfaces, when all is at rest. */
const quick = 60_000;

const restLengths = new WeakMap<SurfaceData, Float32Array>();
let shown = false;

/** Colours the surface by what was chosen; `still` when nothing is being dragged. */
export function recolour(studio: Studio, still = false): void {
  const viewport = studio.viewports[0]!;
  const surface = viewport.surface("mesh");
  if (!surface || memory.heat === "none") return blank(studio, surface);
  if (!still && surface.count > quick) return;
  const stretch = memory.heat === "stretch";
  const values = stretch ? stretches(surface) : displacements(surface);
  const max = rounded(largest(values), stretch ? 1 : 1e-4 * surface.data.scale);
  const range = { min: stretch ? -max : 0, max };
  const colormap = stretch ? "coolwarm" : "viridis";
  surface.colours({ values, per: "vertex", colormap, ...range });
  const told = stretch ? { title: "Stretch of edges", unit: "%" } : { title: "Displacement" };
  viewport.legend.set({ ...told, ...range, colormap });
  shown = true;
}

function blank(studio: Studio, surface: SurfaceView | undefined): void {
  if (!shown) return;
  shown = false;
  surface?.colours(null);
  studio.viewports[0]!.legend.set(null);
}

/** How far each vertex is from where it was (n,), in the unit of the mesh. */
export function displacements({ positions, data }: SurfaceView): Float32Array {
  const rest = data.positions;
  const found = new Float32Array(positions.length / 3);
  for (let vertex = 0, i = 0; vertex < found.length; vertex++, i += 3) {
    const x = positions[i]! - rest[i]!;
    const y = positions[i + 1]! - rest[i + 1]!;
    const z = positions[i + 2]! - rest[i + 2]!;
    found[vertex] = Math.sqrt(x * x + y * y + z * z) * data.scale;
  }
  return found;
}

/** Of the edges at each vertex, the change of length of the one that changed most (n,), in %. */
export function stretches({ positions, data }: SurfaceView): Float32Array {
  const { edges } = data;
  const before = restLengths.get(data) ?? lengths(data.positions, edges);
  restLengths.set(data, before);
  const now = lengths(positions, edges);
  const found = new Float32Array(positions.length / 3);
  for (let edge = 0; edge < now.length; edge++) {
    if (!(before[edge]! > 0)) continue;
    const change = 100 * (now[edge]! / before[edge]! - 1);
    const size = Math.abs(change);
    const [a, b] = [edges[2 * edge]!, edges[2 * edge + 1]!];
    if (size > Math.abs(found[a]!)) found[a] = change;
    if (size > Math.abs(found[b]!)) found[b] = change;
  }
  return found;
}

function lengths(positions: Float32Array, edges: Uint32Array): Float32Array {
  const found = new Float32Array(edges.length / 2);
  for (let edge = 0; edge < found.length; edge++) {
    const a = 3 * edges[2 * edge]!;
    const b = 3 * edges[2 * edge + 1]!;
    const x = positions[a]! - positions[b]!;
    const y = positions[a + 1]! - positions[b + 1]!;
    const z = positions[a + 2]! - positions[b + 2]!;
    found[edge] = Math.sqrt(x * x + y * y + z * z);
  }
  return found;
}

function largest(values: Float32Array): number {
  let most = 0;
  for (const value of values) most = Math.max(most, Math.abs(value));
  return most;
}

/** The next of 1, 2, 5, 10, ... above: a legend that changes all the time cannot be read. */
export function rounded(value: number, least: number): number {
  const wanted = Math.max(value, least);
  const power = 10 ** Math.floor(Math.log10(wanted));
  return power * [1, 2, 5, 10].find((factor) => factor * power >= wanted * 0.999)!;
}
