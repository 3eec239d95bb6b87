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

export const titles = { quads: "Make quads", cage: "Make cage" };

class Page {
  studio: Studio | null = null;
  /** What was chosen to be looked at; null: what there is. */
  private chosen: Sight | null = null;
  /** The other of input and quads is shown while a key is held. */
  comparing = false;
  shown: Shown = { irregular: true, arcs: false, features: true };
  /** Something was asked for, and is shown when it comes in place of the blob that there was. */
  private awaited: { what: "quads" | "cage"; before: string | undefined } | null = null;

  show(sight: Sight): void {
    this.chosen = sight;
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

  /** The job that makes something, if it is being made. */
  job(what: "quads" | "cage") {
    return this.studio?.jobs.find((one) => one.tab === "quad" && one.title === titles[what]);
  }

  async make(what: "quads" | "cage"): Promise<void> {
    if (this.job(what)) return;
    const before = this.studio!.state?.tabs.quad.view.surfaces[what]?.data;
    const asked = await this.studio!.do("quad", what === "quads" ? "run" : "make_cage");
    if (asked) this.awaited = { what, before };
  }

  /** What was asked for may be here. */
  arrive(view: QuadView): void {
    if (!this.awaited) return;
    const { what, before } = this.awaited;
    const there = view.surfaces[what]?.data;
    if (there && (there !== before || view.result?.current)) {
      this.chosen = what;
      this.awaited = null;
    }
  }

  /** What is chosen, of what there is. */
  sight(view: QuadView): Sight {
    const made = view.result !== undefined;
    const there = {
      ...{ input: true, cage: view.surfaces.cage !== undefined },
      ...{ quads: made, quality: made, patches: made },
    };
    if (this.chosen && there[this.chosen]) return this.chosen;
    return made ? "quads" : "input";
  }

  /** What is in the picture. */
  seen(view: QuadView): Sight {
    const sight = this.sight(view);
    if (!this.comparing || !view.result) return sight;
    return sight === "input" ? "quads" : "input";
  }
}

export const page = new Page();
