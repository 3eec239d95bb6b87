/** The tool in hand over a viewport: turns the camera, picks, outlines and paints. */
import { Stroke, type Painted } from "./brush";
import type { Events } from "./events";
import { outlining, shape, sheet } from "./outline";
import { modifiers, Pointer, STEADY, type Drag } from "./pointer";
import { dot, subtract, toLocal } from "./vectors";
import type { Hit, Tool, ViewportEvents } from "./types";
import type { Viewport } from "./viewport";

/** Half turns for a drag over the viewport's height. */
const TURN = Math.PI;

/** Of the scene's size, the brush's radius unless it is set. */
const BRUSH = 0.08;

/** Hovering waits this many times as long as finding what is hovered takes. */
const PATIENCE = 3;

export class Hand {
  private held: Tool = "orbit";
  private readonly sheet: SVGSVGElement;
  private readonly ring: SVGElement;
  private readonly pointer: Pointer;
  private readonly painted: Painted;
  private place: [number, number] | null = null;
  private waiting = 0;
  private zoomed: { x: number; y: number; time: number; point: [number, number, number] } | null =
    null;

  constructor(
    private readonly viewport: Viewport,
    private readonly events: Events<ViewportEvents>,
  ) {
    this.sheet = sheet(viewport.element);
    this.ring = shape(this.sheet, "circle", "viewer-ring");
    this.painted = this.painting();
    this.pointer = new Pointer(viewport.element, {
      press: (x, y, event) => this.press(x, y, event),
      click: (x, y, event) => this.click(x, y, event),
      doubleClick: () => this.held === "orbit" && viewport.frame(),
      hover: (x, y) => this.hover([x, y]),
      leave: () => this.hover(null),
      wheel: (x, y, factor) => this.wheel(x, y, factor),
    });
    viewport.element.dataset.tool = this.held;
  }

  /** What the brush gets from the viewport, and what is done with its strokes. */
  private painting(): Painted {
    const { viewport, events } = this;
    return {
      hit: (x, y) => viewport.hitAt(x, y, 0),
      surface: (key) => viewport.surface(key),
      sight: () => viewport.sight(),
      radius: () => this.radius,
      pixels: (hit) => this.pixels(hit),
      at: (x, y, hit) => this.circle([x, y], hit),
      touched(surface, ids, event, done) {
        surface.highlight({ ids, colour: viewport.brushColour });
        events.emit("stroke", { surface: surface.key, ids, done, ...modifiers(event) });
      },
      cancelled: (surface) => surface.highlight(null),
    };
  }

  get tool(): Tool {
    return this.held;
  }

  set tool(tool: Tool) {
    if (tool === this.held) return;
    this.pointer.cancel();
    this.held = tool;
    this.viewport.element.dataset.tool = tool;
    this.look();
  }

  /** Ends a drag as if it had not been. */
  cancel(): void {
    this.pointer.cancel();
  }

  private get radius(): number {
    return this.viewport.brushRadius || BRUSH * this.viewport.frameNow.scale;
  }

  /** Pixels of the brush's radius where a hit is. */
  private pixels(hit: Hit | null): number {
    const { frameNow, pose } = this.viewport;
    const sight = this.viewport.sight();
    const point = hit ? toLocal(frameNow, hit.point) : pose.target;
    const depth = dot(subtract(point, sight.eye.position), sight.eye.ahead);
    return (this.radius / frameNow.scale) * (sight.focal / Math.max(depth, 1e-6));
  }

  private press(x: number, y: number, event: PointerEvent): Drag | null {
    const left = event.button === 0;
    if (left && this.viewport.gizmo.busy) return null;
    this.hover(null);
    const turns = !left || event.altKey || this.held === "orbit" || this.held === "pick";
    if (turns) return event.shiftKey ? this.panning(x, y) : this.orbiting(x, y);
    if (this.held === "brush")
      return Stroke.begin(this.painted, x, y, event) ?? this.orbiting(x, y);
    return this.outlining(x, y, this.held === "lasso" ? "lasso" : "rectangle");
  }

  /** A drag in steps, which begins when the pointer is no longer steady. */
  private navigating(x: number, y: number, step: (right: number, down: number) => void): Drag {
    let last: [number, number] = [x, y];
    let steady = true;
    return {
      move: (px, py) => {
        steady &&= Math.hypot(px - x, py - y) < STEADY;
        if (steady) return;
        const height = this.viewport.element.clientHeight || 1;
        step((px - last[0]) / height, (py - last[1]) / height);
        last = [px, py];
        this.viewport.turned();
      },
      end: () => undefined,
      cancel: () => undefined,
    };
  }

  private orbiting(x: number, y: number): Drag {
    const { viewport } = this;
    return this.navigating(x, y, (right, down) => viewport.pose.orbit(-right * TURN, down * TURN));
  }

  private panning(x: number, y: number): Drag {
    const { viewport } = this;
    return this.navigating(x, y, (right, down) => viewport.pose.pan(-right, down));
  }

  private outlining(x: number, y: number, kind: "rectangle" | "lasso"): Drag {
    return outlining(kind, this.sheet, [x, y], (corners, event) => {
      const { width, height } = this.viewport.sight();
      const polygon = corners.map(([px, py]): [number, number] => [
        (2 * px) / width - 1,
        1 - (2 * py) / height,
      ]);
      const camera = this.viewport.camera();
      this.events.emit("outline", { polygon, camera, ...modifiers(event) });
    });
  }

  private click(x: number, y: number, event: PointerEvent): void {
    if (this.held !== "pick" || event.altKey) return;
    const hit = this.viewport.hitAt(x, y);
    const mark = this.viewport.marks.at(x, y);
    if (hit) this.events.emit("pick", { ...hit, mark, ...modifiers(event) });
    else this.events.emit("miss", modifiers(event));
  }

  private wheel(x: number, y: number, factor: number): void {
    this.viewport.pose.zoom(factor, this.zoomPoint(x, y));
    this.viewport.turned();
    this.hover(this.place);
  }

  /** The point of the scene that stays where it is seen; the same during one turn of the wheel. */
  private zoomPoint(x: number, y: number): [number, number, number] {
    const now = performance.now();
    const before = this.zoomed;
    const same = before && Math.hypot(before.x - x, before.y - y) < 2 && now - before.time < 400;
    const point = same ? before.point : this.pointAt(x, y);
    this.zoomed = { x, y, time: now, point };
    return point;
  }

  /** What is at a pixel, or how far the target is. */
  private pointAt(x: number, y: number): [number, number, number] {
    const { frameNow, pose } = this.viewport;
    const hit = this.viewport.hitAt(x, y, 0);
    if (hit) return toLocal(frameNow, hit.point);
    const { origin, direction } = this.viewport.sight().ray(x, y);
    return direction.map((part, k) => origin[k]! + part * pose.distance) as [
      number,
      number,
      number,
    ];
  }

  private hover(place: [number, number] | null): void {
    this.place = place;
    if (!place) return this.look();
    if (this.waiting) return;
    this.waiting = requestAnimationFrame(() => this.look());
  }

  /** Shows what the tool would do at the pointer. */
  private look(): void {
    const { place, held } = this;
    this.waiting = 0;
    const wants = held === "pick" || held === "brush" || this.events.has("hover");
    if (!place || !wants || this.viewport.gizmo.busy) {
      this.ring.removeAttribute("r");
      if (this.events.has("hover")) this.events.emit("hover", null);
      return;
    }
    const started = performance.now();
    const hit = this.viewport.hitAt(...place, held === "pick" ? undefined : 0);
    this.events.emit("hover", hit);
    this.circle(place, hit);
    this.rest(performance.now() - started);
  }

  /** After a costly look, the next one has to wait. */
  private rest(cost: number): void {
    if (cost < 8) return;
    this.waiting = window.setTimeout(() => {
      this.waiting = 0;
      if (this.place) this.hover(this.place);
    }, PATIENCE * cost);
  }

  private circle(place: [number, number], hit: Hit | null): void {
    if (this.held === "pick" && hit) {
      const { left, top } = this.viewport.element.getBoundingClientRect();
      const [x, y] = this.viewport.project(hit.surface, hit.vertex);
      this.draw(x - left, y - top, 5, "vertex");
    } else if (this.held === "brush") {
      this.draw(...place, Math.max(1.5, this.pixels(hit)), hit ? "brush" : "away");
    } else {
      this.ring.removeAttribute("r");
    }
  }

  private draw(x: number, y: number, radius: number, kind: string): void {
    this.ring.setAttribute("cx", x.toFixed(1));
    this.ring.setAttribute("cy", y.toFixed(1));
    this.ring.setAttribute("r", radius.toFixed(1));
    this.ring.setAttribute("data-kind", kind);
  }

  dispose(): void {
    this.pointer.dispose();
    cancelAnimationFrame(this.waiting);
  }
}
