/** How much a surface bends, as colours. */

import type { SurfaceView, Viewport } from "../../viewer/index.ts";
import { allNormals } from "../../viewer/normals.ts";

/** Part of the vertices that the range of colours holds. */
const HELD = 0.96;

/** Vertices up to which colours follow every frame. */
const QUICK = 60_000;

/**
 * Mean curvature (n,) of a surface by vertices, in 1 / unit of the mesh; above 0 where it bulges
 * outward. Along each edge it is how far the normal turns, for the way; the mean over all edges.
 */
export function meanCurvature({ positions, data, count }: SurfaceView): Float32Array {
  const normals = new Float32Array(3 * count);
  allNormals(positions, data.triangles, normals);
  for (let i = 0; i < normals.length; i += 3) {
    const length = Math.hypot(normals[i]!, normals[i + 1]!, normals[i + 2]!) || 1;
    for (let k = i; k < i + 3; k++) normals[k]! /= length;
  }
  const sums = new Float32Array(count);
  const edges = new Float32Array(count);
  for (let e = 0; e < data.edges.length; e += 2) {
    const [a, b] = [3 * data.edges[e]!, 3 * data.edges[e + 1]!];
    let [turn, way] = [0, 0];
    for (let k = 0; k < 3; k++) {
      const step = positions[b + k]! - positions[a + k]!;
      turn += (normals[b + k]! - normals[a + k]!) * step;
      way += step * step;
    }
    if (way === 0) continue;
    for (const vertex of [a / 3, b / 3]) {
      sums[vertex]! += turn / way;
      edges[vertex]! += 1;
    }
  }
  return sums.map((sum, vertex) => sum / (edges[vertex] || 1) / data.scale);
}

/** Colours of a surface by its curvature; the range stays until it is begun anew. */
export class CurvatureColours {
  private range = 0;
  private on = false;

  /** Shows them or takes them away. */
  show(viewport: Viewport, surface: SurfaceView, on: boolean): void {
    if (!on) {
      if (this.on) {
        surface.colours(null);
        viewport.legend.set(null);
      }
      this.on = false;
      return;
    }
    const values = meanCurvature(surface);
    if (!this.on || this.range === 0) this.range = rangeOf(values);
    this.on = true;
    this.paint(surface, values);
    const [min, max] = [-this.range, this.range];
    viewport.legend.set({ title: "Mean curvature", min, max, colormap: "coolwarm" });
  }

  /** The surface has moved. */
  follow(surface: SurfaceView): void {
    if (this.on && surface.count <= QUICK) this.paint(surface, meanCurvature(surface));
  }

  /** The surface is another one. */
  forget(): void {
    this.on = false;
    this.range = 0;
  }

  private paint(surface: SurfaceView, values: Float32Array): void {
    const [min, max] = [-this.range, this.range];
    surface.colours({ values, per: "vertex", colormap: "coolwarm", min, max });
  }
}

function rangeOf(values: Float32Array): number {
  const sizes = values.map(Math.abs).sort();
  const largest = sizes[Math.floor(HELD * (sizes.length - 1))] ?? 0;
  return largest > 0 ? Number(largest.toPrecision(2)) : 1;
}
