/** Dragging pins and lines: the surface follows in the page, without waiting for the server. */

import type { Message } from "../../messages.ts";
import type { BasisHeader } from "../../state.ts";
import { add, scaled, subtract } from "../../viewer/vectors.ts";
import type { Point, Viewport } from "../../viewer/index.ts";
import type { Studio } from "../tab.ts";
import { own, type Placed } from "./state.ts";
import { pulled } from "./places.ts";

export const SURFACE = "surface";

/** Milliseconds after which a surface whose answer is not known follows by frames. */
const PATIENCE = 500;

/** Pixels that a click may move. */
const STEADY = 4;

/** One drag of a pin, of a line, or of a point of a line. */
export class Drag {
  by: Point = [0, 0, 0];
  /** It has ended, and the state has what was committed. */
  done = false;
  private ended = false;
  private basis: { start: Float32Array; response: Float32Array } | null = null;
  private framed = false;
  private readonly timer: number;
  private readonly keys = new AbortController();

  /**
   * @param point of the line; null for all of it
   * @param moved called when positions changed
   */
  constructor(
    private readonly studio: Studio,
    readonly placed: Placed,
    readonly point: number | null,
    private readonly moved: () => void,
  ) {
    studio.grab("design", { name: placed.part.name, ...this.where });
    this.timer = window.setTimeout(() => {
      this.framed = this.basis === null;
      this.follow();
    }, PATIENCE);
    addEventListener("keydown", ({ key }) => key === "Escape" && this.cancel(), {
      signal: this.keys.signal,
    });
  }

  private get where(): object {
    return this.point === null ? {} : { index: this.point, reach: own.reach };
  }

  /** Where the line is now. */
  get line(): Point[] {
    const { line } = this.placed;
    if (this.point !== null) return pulled(line, this.point, this.by, own.reach);
    return line.map((point) => add(point, this.by));
  }

  /** How the surface answers. */
  answered({ header, arrays }: Message<BasisHeader>): void {
    const same = header.name === this.placed.part.name && (header.index ?? null) === this.point;
    if (!same || this.ended) return;
    const { start, response } = arrays as Record<string, Float32Array>;
    this.basis = { start: start!, response: response! };
    this.framed = false;
    this.follow();
  }

  to(by: Point): void {
    if (this.ended) return;
    this.by = by;
    this.follow();
  }

  private follow(): void {
    if (this.basis) {
      this.blend(this.by);
      this.studio.live("design", ...this.action({ blended: true }));
    } else if (this.framed) this.studio.live("design", ...this.action());
    this.moved();
  }

  private blend(by: Point): void {
    const { start, response } = this.basis!;
    this.studio.viewports[0]!.surface(SURFACE)?.blend(start, response, by);
  }

  private action(more: object = {}): [string, object] {
    const { name, kind } = this.placed.part;
    if (kind === "pins") {
      return ["move_pin", { name, to: add(this.placed.line[0]!, this.by), ...more }];
    }
    return ["move_curve", { name, by: this.by, ...this.where, ...more }];
  }

  async end(): Promise<void> {
    if (!this.close()) return;
    const moved = this.by.some((x) => x !== 0);
    if (!moved || !(await this.studio.do("design", ...this.action()))) this.back();
    this.done = true;
    this.studio.changed();
  }

  /** Ends it as if it had not been; Escape does the same. */
  cancel(): void {
    if (!this.close()) return;
    this.back();
    this.done = true;
    this.studio.changed();
  }

  /** Ends it, unless it has ended already. */
  private close(): boolean {
    const first = !this.ended;
    this.ended = true;
    this.keys.abort();
    clearTimeout(this.timer);
    return first;
  }

  /** As it was; the server does not know what the page has blended. */
  private back(): void {
    this.by = [0, 0, 0];
    if (this.basis) this.blend(this.by);
    this.studio.drop();
  }
}

/** What a press on a mark begins. */
export interface Held {
  /** Where it is in space. */
  position: Point;
  /** It was pressed and let go without a move. */
  click(): void;
  begin(): Drag;
}

/**
 * Has marks dragged in the plane of the screen.
 *
 * @param held what the mark of an id is; null where it is not to be dragged
 */
export function draggingMarks(viewport: Viewport, held: (mark: string) => Held | null): () => void {
  const { element } = viewport;
  const ended = new AbortController();
  const at = (event: PointerEvent): [number, number] => {
    const { left, top } = element.getBoundingClientRect();
    return [event.clientX - left, event.clientY - top];
  };
  const down = (event: PointerEvent) => {
    if (event.button !== 0 || event.altKey || viewport.gizmo.busy) return;
    const start = at(event);
    const mark = viewport.marks.at(...start);
    const thing = mark === null ? null : held(mark);
    if (!thing) return;
    event.stopImmediatePropagation();
    element.focus({ preventScroll: true });
    element.setPointerCapture(event.pointerId);
    follow(event.pointerId, start, thing);
  };
  const follow = (pointer: number, start: [number, number], thing: Held) => {
    let drag: Drag | null = null;
    const until = new AbortController();
    const listen = (
      name: "pointermove" | "pointerup" | "pointercancel",
      does: (event: PointerEvent) => void,
    ) =>
      element.addEventListener(
        name,
        (event) => {
          if (event.pointerId !== pointer) return;
          event.stopImmediatePropagation();
          does(event);
        },
        { capture: true, signal: AbortSignal.any([until.signal, ended.signal]) },
      );
    listen("pointermove", (event) => {
      const place = at(event);
      if (!drag && Math.hypot(place[0] - start[0], place[1] - start[1]) < STEADY) return;
      drag ??= thing.begin();
      drag.to(acrossScreen(viewport, thing.position, start, place));
    });
    listen("pointerup", () => {
      until.abort();
      if (drag) void drag.end();
      else thing.click();
    });
    listen("pointercancel", () => {
      until.abort();
      drag?.cancel();
    });
  };
  element.addEventListener("pointerdown", down, { capture: true, signal: ended.signal });
  return () => ended.abort();
}

/** The way in space between two pixels, at the depth of a point. */
function acrossScreen(
  viewport: Viewport,
  position: Point,
  from: [number, number],
  to: [number, number],
): Point {
  const { centre, scale } = viewport.frameNow;
  const sight = viewport.sight();
  const [, , depth] = sight.project(scaled(subtract(position, centre), 1 / scale));
  const way = subtract(sight.ray(...to).direction, sight.ray(...from).direction);
  return scaled(way, depth * scale);
}
