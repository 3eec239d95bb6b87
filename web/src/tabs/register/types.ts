/** What the server says of the register tab. */

import type { View } from "../../state.ts";
import type { Figure } from "../../ui/index.ts";
import type { Colormap } from "../../viewer/index.ts";
import type { Studio } from "../tab.ts";

export type SideName = "source" | "target";
export const sideNames = ["source", "target"] as const;

export const mediators = ["sphere", "quadruped", "humanoid"] as const;

export interface Morphing {
  path: "linear" | "rotation";
  time: "linear" | "smoothstep";
  frames: number;
  seconds: number;
  sweep: "top" | "bottom" | "left" | "right" | "front" | "back" | null;
}

export interface RegisterState {
  source: string | null;
  target: string | null;
  /** The mesh that is the mediator, if it is none by name. */
  mediator: string | null;
  recipe: {
    mediator: string;
    landmarks: unknown[];
    regions: [string, string] | null;
    rule: "nearest" | "literal";
    distortion: number;
    settings: Record<string, unknown>;
    seed: number;
    about: string;
    morph: Morphing;
  };
}

/** A landmark: vertices, and where it is on both if it is no pair of vertices. */
export interface Marked {
  source: number;
  target: number;
  points: number[][];
}

/** A button for it is named in {@link Trouble}. */
export type Fix =
  "weld" | "oriented" | "largest_component" | "without_degenerate_faces" | "flipped";

export interface Trouble {
  message: string;
  /** The surface that it is about; empty for landmarks. */
  side: SideName | "";
  fixes: Fix[];
}

/** What model or target can be coloured by: a blob with `values`. */
export interface HeatMap {
  title: string;
  on: "model" | "target";
  per: "vertex" | "face";
  data: string;
  colormap: Exclude<Colormap, "categorical">;
  limits: [number, number];
  unit: string;
}

export interface Result {
  /** The model in the form of the target, with `start`, its positions in the form of the source,
   * and `bridged`, its vertices in holes of the target. */
  shapes: string;
  /** Positions along a path on which parts turn; null while it is not prepared. */
  turning: string | null;
  /** When each vertex starts; null: all at once. */
  delay: string | null;
  colours: HeatMap[];
  figures: Figure[];
  /** Vertices of the model. */
  landmarks: number[];
  /** The vertex of the target that is farthest from the model. */
  missed: number | null;
  /** Whether it was made by the recipe as it is now. */
  current: boolean;
}

export interface RegisterView extends View {
  /** What to do now, in a sentence. */
  next: string;
  ready: boolean;
  landmarks?: Marked[];
  /** Attributes of both meshes that can be labels of regions. */
  labels?: [string[], string[]];
  trouble?: Trouble | null;
  /** Whether parts can be seen to turn. */
  turnable?: boolean;
  result?: Result;
}

export type Props = { state: RegisterState; view: RegisterView; studio: Studio };
