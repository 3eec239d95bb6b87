/** The deform tab's state and view, as the server has them. */

import type { Packed, View } from "../../state.ts";
import type { Figure, Vector } from "../../ui/index.ts";

export type Kind = "fixed" | "handles" | "features" | "pins";
export type Keep = "rigid" | "circle" | "plane" | "line";
export type Mode = "replace" | "add" | "subtract" | "toggle";

/** A pose against rest: about the centroid, its rotation a vector in degrees. */
export interface Move {
  translation: Vector;
  rotation: Vector;
  scale: number;
}

/** Something that was found on the surface. */
export interface Found {
  name: string;
  kind: "rim" | "hole" | "boss" | "line" | "pad";
  figures: string;
  count: number;
  /** A blob with its vertices. */
  ids: string;
  /** One of them, for its name. */
  at: number;
  /** The feature that keeps it. */
  part: string | null;
}

interface Region {
  name: string;
  count: number;
  /** A blob with its vertices. */
  ids: string;
}

export interface FixedPart extends Region {
  kind: "fixed";
}

export interface HandlePart extends Region {
  kind: "handles";
  centre: Vector;
  move: Move;
}

export interface FeaturePart extends Region {
  kind: "features";
  keep: Keep;
  scale: number;
  radius: number | null;
  /** Of the circle; null if none is kept. */
  rest_radius: number | null;
  /** How many features of one name it is. */
  several: number;
}

export interface PinPart {
  kind: "pins";
  name: string;
  /** The vertex that is pinned; null for another point of the surface. */
  vertex: number | null;
  to: Vector;
}

export type RegionPart = FixedPart | HandlePart | FeaturePart;
export type Part = RegionPart | PinPart;

export const isRegion = (part: Part): part is RegionPart => part.kind !== "pins";

export interface DeformState {
  mesh: string | null;
  selection: Packed;
  recipe: {
    method: "linear" | "refined";
    symmetry: { point: Vector; normal: Vector } | null;
    offsets: { name: string | null; between: [string, string] }[];
    finding: { angle: number };
  };
}

export interface DeformView extends View {
  /** Vertices in the selection. */
  selected?: number;
  /** null: not looked for, as it takes long on this mesh. */
  found?: Found[] | null;
  parts?: Part[];
  figures?: Figure[];
  /** Why nothing moves. */
  trouble?: string | null;
  /** The systems are being factored: nothing moves until they are. */
  preparing?: boolean;
  /** What to do before anything can move. */
  next?: string | null;
}

export const colours: Record<Kind | "selection" | "found", string> = {
  fixed: "#7b61c9",
  handles: "#ef8a26",
  features: "#3f82e0",
  pins: "#c2417c",
  selection: "#21b06f",
  found: "#f2d13c",
};
