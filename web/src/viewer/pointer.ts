/** The mouse over a viewport: which drag a press begins, clicks, the wheel and hovering. */
import type { Modifiers } from "./types";

/** What goes on while a button is held; places are in pixels of the viewport. */
export interface Drag {
  move(x: number, y: number, event: PointerEvent): void;
  end(event: PointerEvent): void;
  cancel(): void;
}

/** What a viewport does with the mouse. */
export interface Handled {
  /** The drag that a press begins, null for none. */
  press(x: number, y: number, event: PointerEvent): Drag | null;
  /** A press and release of the left button without a drag. */
  click(x: number, y: number, event: PointerEvent): void;
  doubleClick(): void;
  hover(x: number, y: number): void;
  leave(): void;
  wheel(x: number, y: number, factor: number): void;
}

/** Pixels that a click may move. */
export const STEADY = 4;

/** Growth of the distance for each pixel of the wheel; pinching sends small steps. */
const WHEEL = 0.0012;
const PINCH = 0.01;
const LINE = 33;

export const modifiers = (event: MouseEvent): Modifiers => ({
  shift: event.shiftKey,
  alt: event.altKey,
  ctrl: event.ctrlKey || event.metaKey,
});

export class Pointer {
  private drag: Drag | null = null;
  private start: [number, number] = [0, 0];
  private moved = false;
  private readonly ended = new AbortController();

  constructor(
    private readonly element: HTMLElement,
    private readonly handled: Handled,
  ) {
    const { signal } = this.ended;
    const listen = <Name extends keyof HTMLElementEventMap>(
      name: Name,
      handler: (event: HTMLElementEventMap[Name]) => void,
    ) => element.addEventListener(name, handler, { signal, passive: false });
    listen("pointerdown", (event) => this.down(event));
    listen("pointermove", (event) => this.move(event));
    listen("pointerup", (event) => this.up(event));
    listen("pointercancel", () => this.cancel());
    listen("pointerleave", () => this.handled.leave());
    listen("dblclick", () => this.handled.doubleClick());
    listen("contextmenu", (event) => event.preventDefault());
    listen("wheel", (event) => this.wheel(event));
  }

  /** Ends a drag as if it had not been. */
  cancel(): void {
    this.drag?.cancel();
    this.drag = null;
  }

  private at(event: MouseEvent): [number, number] {
    const { left, top } = this.element.getBoundingClientRect();
    return [event.clientX - left, event.clientY - top];
  }

  private down(event: PointerEvent): void {
    if (this.drag) return;
    this.element.focus({ preventScroll: true });
    this.start = this.at(event);
    this.moved = false;
    this.drag = this.handled.press(...this.start, event);
    if (this.drag) this.element.setPointerCapture(event.pointerId);
    if (event.button === 1) event.preventDefault();
  }

  private move(event: PointerEvent): void {
    const [x, y] = this.at(event);
    if (!this.drag) return this.handled.hover(x, y);
    this.moved ||= Math.hypot(x - this.start[0], y - this.start[1]) >= STEADY;
    this.drag.move(x, y, event);
  }

  private up(event: PointerEvent): void {
    const { drag } = this;
    this.drag = null;
    drag?.end(event);
    if (drag && !this.moved && event.button === 0) this.handled.click(...this.start, event);
  }

  private wheel(event: WheelEvent): void {
    event.preventDefault();
    const pixels = event.deltaY * (event.deltaMode === WheelEvent.DOM_DELTA_LINE ? LINE : 1);
    const factor = Math.exp(pixels * (event.ctrlKey ? PINCH : WHEEL));
    this.handled.wheel(...this.at(event), Math.max(0.2, Math.min(5, factor)));
  }

  dispose(): void {
    this.cancel();
    this.ended.abort();
  }
}
