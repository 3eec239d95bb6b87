/** What the server says of the combine tab. */

import type { Packed, View } from "../../state.ts";
import type { Figure } from "../../ui/index.ts";
import type { Colormap } from "../../viewer/index.ts";
import type { Studio } from "../tab.ts";

export type Kind = "pairs" | "landmarks";
export type SideName = "a" | "b";
export const sideNames = ["a", "b"] as const;
/** What makes another mesh of one. */
export type Repair = "weld" | "oriented" | "largest_component" | "without_degenerate_faces";
export type Fix = "fill_holes" | "flip_b" | "align" | "propose" | Repair;

/** Why the meshes cannot be combined yet. */
export interface Trouble {
  message: string;
  /** What may help, each in one step. */
  fixes: Fix[];
  /** The mesh that is to be repaired. */
  side: SideName | "";
}

export interface Morphing {
  path: "linear" | "rotation";
  time: "linear" | "smoothstep";
  frames: number;
  seconds: number;
  sweep: "top" | "bottom" | "left" | "right" | "front" | "back" | null;
}

export interface CombineState {
  a: string | null;
  b: string | null;
  recipe: {
    pairs: "auto" | unknown;
    landmarks: unknown;
    fill_holes: boolean;
    drop_fill: boolean;
    outer: [number | null, number | null];
    snap: number;
    attributes: boolean;
    flip_b: boolean;
    align: boolean;
    about: string;
    morph: Morphing;
  };
}

export interface Loop {
  /** One of its vertices, to name it by. */
  vertex: number;
  vertices: Packed;
  length: number;
  /** It is matched; others are holes. */
  outer: boolean;
}

/** What the result can be coloured by: a blob with `rgb`, or with `values`. */
export interface ResultColour {
  title: string;
  per: "vertex" | "face";
  data: string;
  colormap: Colormap | null;
  limits: [number, number] | null;
  unit: string;
}

export interface Result {
  /** A surface in the form of a, with `other`, its positions on b. */
  shapes: string;
  /** Positions in the common plane, `edges_a` and `edges_b`. */
  plane: string;
  /** Positions along a path on which parts turn; null while it is not prepared. */
  turning: string | null;
  /** When each vertex starts; null: all at once. */
  delay: string | null;
  colours: ResultColour[];
  figures: Figure[];
  /** The vertex of the result that each pair became. */
  pairs: number[];
  landmarks: number[];
  /** Whether it was made by the recipe as it is now. */
  current: boolean;
}

export interface CombineView extends View {
  /** What to do now, in a sentence. */
  next: string;
  ready: boolean;
  sides?: Record<SideName, { loops: Loop[]; sound: boolean }>;
  pairs?: Record<SideName, number>[];
  landmarks?: Record<SideName, number>[];
  trouble?: Trouble | null;
  /** What does not stand in the way, and should be looked at. */
  advice?: Trouble | null;
  /** Whether the recipe has points, which are taken to vertices near by. */
  snaps?: boolean;
  /** Vertices up to which parts can be seen to turn. */
  turnable?: number;
  result?: Result;
}

/** What the parts of the panel are given. */
export interface Props {
  state: CombineState;
  view: CombineView;
  studio: Studio;
}
