/** What only the page knows of the deform tab: what is looked at, and how. */

import type { Studio } from "../tab.ts";
import type { DeformState, DeformView, Kind, Move, Part } from "./types.ts";

export type Heat = "none" | "displacement" | "stretch";

export const memory = {
  /** The part whose controls are shown. */
  part: null as { kind: Kind; name: string } | null,
  /** Outlines select what the surface hides, too. */
  hidden: false,
  /** Of the brush, as a share of the surface's size. */
  brush: 0.05,
  /** Which of what was found is listed. */
  filter: "all",
  /** Names of what was found are shown on the surface. */
  names: false,
  /** What of the list is under the pointer. */
  hovered: null as string | null,
  heat: "none" as Heat,
  /** The surface at rest is shown behind. */
  ghost: false,
  /** The surface at rest is shown instead. */
  comparing: false,
  /** Where the handle is that is being dragged. */
  dragged: null as Move | null,
};

/** Of the tab, as the server has it last. */
export const viewOf = (studio: Studio) => studio.state?.tabs.deform.view as DeformView | undefined;

export const stateOf = (studio: Studio) =>
  studio.state?.tabs.deform.state as DeformState | undefined;

/** The part whose controls are shown, if it is still there. */
export function chosen(view: DeformView | undefined): Part | undefined {
  const { part } = memory;
  return view?.parts?.find((one) => one.kind === part?.kind && one.name === part.name);
}

/** Shows the controls of a part; with a handle or a pin comes the tool that moves it. */
export function choose(studio: Studio, kind: Kind, name: string): void {
  memory.part = { kind, name };
  memory.dragged = null;
  if (kind === "handles" || kind === "pins") studio.take("move");
  studio.changed();
}

export function unchoose(studio: Studio): void {
  memory.part = null;
  memory.dragged = null;
  studio.changed();
}

/** Another radius of the brush, by a factor. */
export function resizeBrush(studio: Studio, factor: number): void {
  memory.brush = Math.min(0.5, Math.max(0.005, memory.brush * factor));
  studio.changed();
}

const often = 100; // milliseconds: nobody reads figures that change more often
let scheduled = 0;

/** Draws the panel again soon, however often it is asked for until then. */
export function soon(studio: Studio): void {
  scheduled ||= window.setTimeout(() => {
    scheduled = 0;
    studio.changed();
  }, often);
}
