/** What the server says of the quad tab. */

import type { Packed, View } from "../../state.ts";
import type { Figure } from "../../ui/index.ts";

export type Layout = "auto" | "field" | "vsa";
export type Axis = "x" | "y" | "z";
type Point = [number, number, number];

export interface QuadState {
  mesh: string | null;
  recipe: {
    quads: number | null;
    edge_length: number | null;
    layout: Layout;
    patches: number | null;
    /** Degrees, or pairs of vertices; null: found. */
    sharp: number | Packed | null;
    density: string | null;
    symmetry: Axis | { point: Point; normal: Point } | null;
    seed: number;
  };
  cage: { surface: string; vertices: number; faces: number } | null;
}

/** What is known before quads are made. */
export interface Wish {
  area: number;
  /** Edges on boundaries. */
  border: number;
  /** Vertex attributes that can be a density. */
  densities: string[];
  /** So large that the rest is left out. */
  large: boolean;
  /** A blob with the edges that are kept; sharpest first, with `angles`, where an angle says which. */
  lines?: string;
  /** Edge lengths at the vertices, if they differ. */
  sizes?: { data: string; limits: [number, number] };
  /** Of symmetry: a point and the normal. */
  plane?: [Point, Point];
}

export interface Result {
  /** A blob: `shape`, `patch`, `arcs`, `irregular` and `kind`. */
  details: string;
  /** Of irregular vertices. */
  kinds: { label: string; colour: string; count: number }[];
  figures: Figure[];
  warnings: string[];
  /** Shape of the worst quad. */
  worst: number;
  /** Whether it was made by the recipe as it is now. */
  current: boolean;
}

export interface QuadView extends View {
  /** What to do now, in a sentence. */
  next: string;
  /** What stands in the way of making quads. */
  trouble?: string;
  wish?: Wish;
  result?: Result;
}
