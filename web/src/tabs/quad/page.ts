/** What only the page knows of the quad tab: what is looked at, and how. */

import type { Studio } from "../tab.ts";
import type { QuadState, QuadView } from "./types.ts";

/** What is in the picture. */
export type Sight = "input" | "quads" | "quality" | "patches" | "cage";

interface Shown {
  /** Irregular vertices are marked. */
  irregular: boolean;
  /** Where patches meet. */
  arcs: boolean;
  /** Creases and boundaries. */
  features: boolean;
}

class Page {
  studio: Studio | null = null;
  sight: Sight = "input";
  /** The other of input and quads is shown while a key is held. */
  comparing = false;
  shown: Shown = { irregular: true, arcs: false, features: true };
  /** Something was asked for, and is shown when it comes. */
  awaited: "quads" | "cage" | null = null;

  show(sight: Sight): void {
    this.sight = sight;
    this.studio?.changed();
  }

  set(changes: Partial<Shown>): void {
    Object.assign(this.shown, changes);
    this.studio?.changed();
  }

  compare(comparing: boolean): void {
    if (comparing === this.comparing) return;
    this.comparing = comparing;
    this.studio?.changed();
  }

  /** Changes options of the recipe; `seen` is where it shows what they change. */
  change(options: Partial<QuadState["recipe"]>, seen?: Sight): Promise<boolean> {
    if (seen) this.show(seen);
    return this.studio!.do("quad", "change", { options });
  }

  async make(what: "quads" | "cage"): Promise<void> {
    const asked = await this.studio!.do("quad", what === "quads" ? "run" : "make_cage");
    if (asked) this.awaited = what;
  }

  /** What was asked for may be here. */
  arrive(view: QuadView): void {
    const here = { quads: view.result?.current, cage: view.surfaces.cage !== undefined };
    if (this.awaited && here[this.awaited]) {
      this.sight = this.awaited;
      this.awaited = null;
    }
  }

  /** What is in the picture, of what there is. */
  seen(view: QuadView): Sight {
    const there = this.sight === "cage" ? view.surfaces.cage : view.result;
    const sight = there ? this.sight : view.result && this.sight !== "input" ? "quads" : "input";
    if (!this.comparing || !view.result) return sight;
    return sight === "input" ? "quads" : "input";
  }
}

export const page = new Page();
