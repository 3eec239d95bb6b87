/** What only the page knows of the combine tab: what is looked at, and how. */

import { keep, kept } from "../../shell/kept.ts";
import type { Studio } from "../tab.ts";
import { Pairing } from "../shared/pairing.ts";
import { Player } from "../shared/player.ts";
import { type CombineView, type Kind, sideNames } from "./types.ts";

export type Mode = "sides" | "plane" | "morph";

class Page {
  studio: Studio | null = null;
  mode: Mode = kept<Mode>("combine view", "sides");
  /** Whether both cameras move together. */
  linked = true;
  /** Side by side: the combined mesh in place of both. */
  whole = false;
  /** Flattened: one over the other, in one viewport. */
  overlaid = false;
  /** Whether pairs are marked on the result. */
  marked = false;
  /** Title of what the result is coloured by; empty for nothing. */
  colour = "";
  readonly player = new Player();
  /** A result was asked for, and is shown when it comes. */
  awaited = false;
  readonly pairing = new Pairing(sideNames, {
    add: (kind, [a, b]) => this.studio!.do("combine", "add_pair", { kind, a, b }),
    move: (kind, index, side, vertex) =>
      this.studio!.do("combine", "move_pair", { kind, index, side: sideNames[side], vertex }),
    changed: () => this.told(),
  });

  /** Looks at something else. */
  show(mode: Mode): void {
    const view = this.studio?.state?.tabs.combine.view as CombineView | undefined;
    if (mode !== "sides" && !view?.result)
      return this.studio?.notify("info", "Nothing is combined yet: press Enter, or Combine.");
    this.mode = mode;
    keep("combine view", mode);
    if (mode !== "morph") this.player.stop();
    this.studio?.changed();
  }

  set(changes: Partial<Pick<Page, "linked" | "whole" | "overlaid" | "marked" | "colour">>): void {
    Object.assign(this, changes);
    this.studio?.changed();
  }

  /** Combines, and shows what comes of it. */
  async combine(): Promise<void> {
    this.awaited = (await this.studio?.do("combine", "combine")) ?? false;
  }

  /** The result that was asked for is here. */
  arrive(): void {
    this.awaited = false;
    this.player.stop();
    this.player.seek(0);
    this.show("morph");
  }

  /** The kind that clicks add with a tool. */
  hold(tool: string): void {
    this.pairing.take(tool === "pairs" || tool === "landmarks" ? tool : null);
    if (this.pairing.kind !== null && this.mode !== "sides") this.show("sides");
    else this.told();
  }

  private told(): void {
    this.studio?.changed();
  }

  /** What to do, for the status line; null: as the tool says. */
  hint(mode: Mode): string | null {
    if (mode === "plane") return "Drag to turn, Shift to move, the wheel enlarges";
    if (mode === "morph") return "Space plays the morph; drag to turn";
    const { pending } = this.pairing;
    if (!pending) return null;
    return `Now its partner on the ${pending.side === 0 ? "right" : "left"}; Escape leaves it`;
  }
}

export const page = new Page();

/** What can be looked at now. */
export function modeOf(view: CombineView): Mode {
  return view.result ? page.mode : "sides";
}

export const labelOf = (kind: Kind, index: number) =>
  kind === "pairs" ? String(index + 1) : `L${index + 1}`;
