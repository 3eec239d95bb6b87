/** What the tab of design shows: the server's state and view, and what only the page knows. */

import type { Packed, View } from "../../state.ts";
import type { Figure, Vector } from "../../ui/index.ts";
import type { Point } from "../../viewer/index.ts";
import type { Studio } from "../tab.ts";

export type Refinement = "auto" | "triangles" | "quads";

export interface DesignState {
  cage: string | null;
  recipe: {
    levels: number;
    /** Or a weight for each level. */
    gamma: number | number[];
    axis_gamma: Vector | null;
    axis_smoothing: [boolean, boolean, boolean];
    steps: number;
    interpolating: boolean;
    refinement: Refinement;
  };
  /** The curve that is being drawn, through vertices of its level. */
  stroke: { level: number; through: Packed } | null;
}

export interface Part {
  kind: "pins" | "curves" | "derivatives";
  name: string;
  level: number;
  /** Of the surface that is shown: the one that a pin is at, or near. */
  vertex?: number;
  /** The same of a curve, in turn. */
  path?: Packed;
  /** Where it goes; missing where its level is not shown. */
  to?: Packed;
}

export interface DesignView extends View {
  /** What to do now. */
  next?: string;
  /** The level that is looked at; missing where there is none. */
  shown?: number;
  levels: { vertices: number; faces: number }[];
  /** How many edges of the surface are on edges of each level; those come first. */
  grid: number[];
  /** Vertices of the cage that are let go, and how many. */
  free: Packed;
  let_go: number;
  parts: Part[];
  figures: Figure[];
  conflicts?: string[][];
  /** Vertices along the curve that is being drawn. */
  path?: Packed;
}

/** A pin or curve whose lists are here. */
export interface Placed {
  part: Part;
  /** Vertices of the surface. */
  path: number[];
  /** Where they go. */
  line: Point[];
}

/** What only the page knows. */
export const own = {
  /** The level that clicks mean. */
  level: 1,
  /** Name of the pin or curve in hand. */
  chosen: null as string | null,
  /** The point of its line, if only that is. */
  point: null as number | null,
  /** How far along a line others follow a point, as a part of its length. */
  reach: 0.2,
  cage: true,
  curvature: false,
  /** The vertex that a click would mean. */
  hover: null as number | null,
  /** A slider of a setting is being moved. */
  sliding: false,
};

/** Of levels, from coarse to fine; finer ones have the last. */
const COLOURS = ["#6b7280", "#2f6fd6", "#e0661f", "#17976a", "#b3247f", "#9a7400"];

export const colourOf = (level: number): string => COLOURS[Math.min(level, COLOURS.length - 1)]!;

/** The level that clicks mean: that of the curve that is being drawn, or one that is shown. */
export function levelAt(state: DesignState, view: DesignView): number {
  return state.stroke?.level ?? Math.min(own.level, view.shown ?? 0);
}

/** What constraints of a level are for. */
export function meaning(level: number, levels: number): string {
  if (level === 0) return "the cage: the whole form, broadest";
  if (level === levels) return "the finest: small details";
  return level <= levels / 3 ? "broad" : level <= (2 * levels) / 3 ? "medium" : "fine";
}

/** State and view of the tab now; null before the first. */
export function now(studio: Studio): { state: DesignState; view: DesignView } | null {
  const entry = studio.state?.tabs.design;
  if (!entry) return null;
  return { state: entry.state as DesignState, view: entry.view as DesignView };
}

/** Works at a level; it is shown at least as fine as that. */
export async function workAt(studio: Studio, level: number): Promise<void> {
  const here = now(studio);
  if (!here || level < 0 || level > here.state.recipe.levels) return;
  own.level = level;
  own.hover = null;
  if (level > (here.view.shown ?? 0)) await studio.do("design", "show", { level });
  studio.changed();
}

export function choose(studio: Studio, name: string | null, point: number | null = null): void {
  own.chosen = name;
  own.point = point;
  studio.changed();
  reveal();
}

/** Scrolls to what is chosen in the panel, once it is drawn. */
export function reveal(): void {
  requestAnimationFrame(() => {
    document.querySelector(".panel .row.selected")?.scrollIntoView({ block: "nearest" });
  });
}

export async function remove(studio: Studio, name: string | null): Promise<void> {
  if (name === null) return;
  if (own.chosen === name) choose(studio, null);
  await studio.do("design", "remove", { name });
}
