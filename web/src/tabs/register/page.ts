/** What only the page knows of the register tab: what is looked at, and how. */

import { keep, kept } from "../../shell/kept.ts";
import type { Job } from "../../state.ts";
import { Player } from "../shared/player.ts";
import { Pairing } from "../shared/pairing.ts";
import type { Studio } from "../tab.ts";
import { type RegisterView, sideNames } from "./types.ts";

export type Mode = "sides" | "model";

export const MARKS = "landmarks";
const REGISTER = "Register";

class Page {
  studio: Studio | null = null;
  mode: Mode = "sides";
  /** Whether both cameras move together. */
  linked = kept("register linked", true);
  /** Whether the target is seen through the model. */
  ghost = true;
  /** Whether landmarks are marked on the model. */
  marked = false;
  /** Title of the heat map; empty for none. */
  colour = "Distance from the target";
  readonly player = new Player();
  /** A result was asked for, and is shown when it comes. */
  private awaited = false;
  private running = false;
  readonly pairing = new Pairing(sideNames, {
    add: (_, [source, target]) => this.studio!.do("register", "add_landmark", { source, target }),
    move: (_, index, side, vertex) =>
      this.studio!.do("register", "move_landmark", { index, side: sideNames[side], vertex }),
    changed: () => this.studio?.changed(),
  });

  constructor() {
    this.player.seek(1);
  }

  /** The work on the model, while it goes on. */
  get job(): Job | undefined {
    return this.studio?.jobs.find((one) => one.tab === "register" && one.title === REGISTER);
  }

  private get view(): RegisterView | undefined {
    return this.studio?.state?.tabs.register.view as RegisterView | undefined;
  }

  /** What can be looked at now. */
  get shown(): Mode {
    return this.view?.result || this.job ? this.mode : "sides";
  }

  /** Looks at something else. */
  show(mode: Mode): void {
    if (mode === "model" && !this.view?.result && !this.job)
      return this.studio?.notify("info", "There is no model yet: press Enter, or Register.");
    this.mode = mode;
    if (mode === "sides") this.player.stop();
    this.studio?.changed();
  }

  set(changes: Partial<Pick<Page, "linked" | "ghost" | "marked" | "colour">>): void {
    Object.assign(this, changes);
    keep("register linked", this.linked);
    this.studio?.changed();
  }

  /** Registers, and shows what happens. */
  async register(): Promise<void> {
    if (this.job || !this.studio) return;
    this.player.stop();
    const before = this.mode;
    this.mode = "model";
    this.awaited = await this.studio.do("register", "run");
    if (!this.awaited) this.show(before);
  }

  /** Follows the work: shows its result when it comes. */
  follow(view: RegisterView): void {
    const ended = this.running && !this.job;
    this.running = this.job !== undefined;
    if (!ended) return;
    if (this.awaited && view.result?.current) {
      this.player.stop();
      this.player.seek(1);
      this.mode = "model";
    }
    this.awaited = false;
  }

  /** A tool was taken in hand. */
  hold(tool: string): void {
    this.pairing.take(tool === MARKS ? MARKS : null);
    if (tool === MARKS && this.shown !== "sides") this.show("sides");
    else this.studio?.changed();
  }

  /** Takes a landmark away. */
  remove(index: number): void {
    this.pairing.selected = null; // the others get other numbers
    void this.studio?.do("register", "remove_landmark", { index });
  }

  /** What to do, for the status line; null: as the tool says. */
  hint(): string | null {
    if (this.shown === "model")
      return this.job ? "It deforms while you look; drag to turn" : "Space plays the morph";
    const { pending } = this.pairing;
    if (!pending) return null;
    const side = pending.side === 0 ? "target, on the right" : "source, on the left";
    return `Now the same place on the ${side}; Escape leaves it`;
  }
}

export const page = new Page();
