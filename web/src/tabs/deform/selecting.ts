/** Selecting on the surface: outlines, strokes and clicks become actions. */

import type { Studio } from "../tab.ts";
import type { Modifiers, OutlineEvent, PickEvent, StrokeEvent } from "../../viewer/index.ts";
import { choose, memory, unchoose, viewOf } from "./memory.ts";
import { isRegion, type Kind, type Mode } from "./types.ts";

export const pinMark = "pin ";
export const foundMark = "found ";

/** Shift adds, Ctrl takes away. */
export const modeOf = ({ shift, ctrl }: Pick<Modifiers, "shift" | "ctrl">): Mode =>
  shift ? "add" : ctrl ? "subtract" : "replace";

export function selectOutlined(studio: Studio, event: OutlineEvent): void {
  const { camera, polygon } = event;
  const outline = { camera, polygon, hidden: memory.hidden };
  void studio.do("deform", "select", { outline, mode: modeOf(event) });
}

export async function selectStroked(studio: Studio, event: StrokeEvent): Promise<void> {
  if (!event.done || event.surface !== "mesh") return;
  await studio.do(
    "deform",
    "select_vertices",
    { mode: modeOf(event) },
    { vertices: Uint32Array.from(event.ids) },
  );
  studio.viewports[0]!.surface("mesh")?.highlight(null);
}

/** What a click means with the tool in hand. */
export async function click(studio: Studio, event: PickEvent): Promise<void> {
  const { mark, vertex, shift, ctrl } = event;
  if (mark?.startsWith(pinMark)) return choose(studio, "pins", mark.slice(pinMark.length));
  if (mark?.startsWith(foundMark)) return void toggleFound(studio, mark.slice(foundMark.length));
  if (studio.tool.name === "vertices") {
    const mode = shift || ctrl ? modeOf(event) : "toggle";
    await studio.do("deform", "select_vertices", { mode }, { vertices: Uint32Array.of(vertex) });
  } else if (studio.tool.name === "pin") {
    await pin(studio, vertex);
  } else {
    const part = await partAt(studio, vertex);
    if (part) choose(studio, part.kind, part.name);
    else if (memory.part) unchoose(studio);
  }
}

async function toggleFound(studio: Studio, name: string): Promise<void> {
  const found = viewOf(studio)?.found?.find((one) => one.name === name);
  if (found) await studio.do("deform", "keep", { names: [name], kept: found.part === null });
}

async function pin(studio: Studio, vertex: number): Promise<void> {
  if (!(await studio.do("deform", "add_pin", { vertex }))) return;
  const pins = viewOf(studio)?.parts?.filter((part) => part.kind === "pins");
  const made = pins?.at(-1);
  if (made) memory.part = { kind: "pins", name: made.name };
  studio.changed();
}

/** The part that has a vertex; of several the one that was added last. */
async function partAt(
  studio: Studio,
  vertex: number,
): Promise<{ kind: Kind; name: string } | undefined> {
  const parts = (viewOf(studio)?.parts ?? []).filter(isRegion).reverse();
  for (const part of parts) {
    const ids = (await studio.data(part.ids)).arrays.values as Uint32Array;
    if (ids.includes(vertex)) return part;
  }
  return undefined;
}

/** Makes a part of the selection, and shows its controls. */
export async function add(studio: Studio, kind: "fixed" | "handles" | "features"): Promise<void> {
  if (!(await studio.do("deform", "add", { kind }))) return;
  const made = viewOf(studio)
    ?.parts?.filter((part) => part.kind === kind)
    .at(-1);
  if (made && kind !== "fixed") choose(studio, kind, made.name);
}

export async function removeChosen(studio: Studio): Promise<void> {
  const { part } = memory;
  if (!part) return;
  memory.part = null;
  await studio.do("deform", "remove", part);
}

export async function selectNothing(studio: Studio): Promise<void> {
  if (viewOf(studio)?.selected) await studio.do("deform", "select_vertices", { vertices: [] });
}
