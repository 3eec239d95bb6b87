/** The canvas: one or two viewports side by side, drawn when something changed. */
import { WebGLRenderer } from "three";
import { Pose } from "./pose";
import { Look } from "./themes";
import type { Theme } from "./types";
import { Viewport } from "./viewport";

/** Pixels of the canvas for one of the page, at most. */
const RATIO = 2;

/** Milliseconds after which a picture counts as drawn that is not, as in a hidden tab. */
const LONGEST_WAIT = 500;

const LABELS = ["First view", "Second view"];

/** Figures for those who measure. */
export interface Stats {
  /** Pictures drawn. */
  frames: number;
  /** Milliseconds that the page took for the last picture, without the graphics card. */
  draw: number;
  /** Times that the graphics card was lost. */
  lost: number;
}

export class Stage {
  readonly stats: Stats = { frames: 0, draw: 0, lost: 0 };
  /** If false, changed arrays are sent to the graphics card, and nothing is drawn. */
  drawing = true;
  private readonly element = document.createElement("div");
  private readonly canvas = document.createElement("canvas");
  private readonly notice = document.createElement("div");
  private readonly renderer: WebGLRenderer;
  private readonly look = new Look("light");
  private readonly all: Viewport[] = [];
  private readonly watch: ResizeObserver;
  private shown = 1;
  private scheduled = 0;
  private waiting: (() => void)[] = [];
  private readonly keys = new AbortController();

  /**
   * @param container filled by the canvas; may change its size
   * @throws Error if the browser has no WebGL 2
   */
  constructor(
    private readonly container: HTMLElement,
    options: { antialias?: boolean } = {},
  ) {
    this.renderer = this.made(options.antialias ?? true);
    this.element.className = "viewer";
    this.notice.className = "viewer-notice";
    this.notice.setAttribute("role", "status");
    this.notice.hidden = true;
    this.element.append(this.canvas, this.notice);
    container.append(this.element);
    for (const label of LABELS) this.all.push(this.viewport(label));
    this.watch = new ResizeObserver(() => this.resize());
    this.watch.observe(container);
    this.canvas.addEventListener("webglcontextlost", (event) => this.lost(event));
    this.canvas.addEventListener("webglcontextrestored", () => this.restored());
    const { signal } = this.keys;
    this.element.addEventListener("keydown", (event) => this.key(event), { signal });
    this.theme("light");
    this.layout(1, false);
  }

  private made(antialias: boolean): WebGLRenderer {
    const context = this.canvas.getContext("webgl2", {
      antialias,
      alpha: true,
      powerPreference: "high-performance",
    });
    if (!context) {
      throw new Error(
        "This browser cannot draw surfaces: it has no WebGL 2. " +
          "Switch on hardware acceleration in its settings, or use another browser.",
      );
    }
    const renderer = new WebGLRenderer({ canvas: this.canvas, context });
    renderer.setClearColor(0, 0);
    renderer.setScissorTest(true);
    renderer.autoClear = false;
    return renderer;
  }

  private viewport(label: string): Viewport {
    const host = {
      look: this.look,
      invalidate: (pose?: Pose) => this.invalidate(pose),
      fit: (pose: Pose) => this.fit(pose),
    };
    const viewport = new Viewport(host, label);
    this.element.append(viewport.element);
    return viewport;
  }

  /** The viewports that are shown. */
  get viewports(): Viewport[] {
    return this.all.slice(0, this.shown);
  }

  /** Shows one viewport, or two side by side; linked ones are seen from the same side. */
  layout(count: 1 | 2, linked: boolean): Viewport[] {
    this.shown = count;
    this.element.dataset.viewports = String(count);
    const [first, second] = this.all as [Viewport, Viewport];
    const together = count === 2 && linked;
    if (together) second.pose = first.pose;
    else if (second.pose === first.pose) second.pose = new Pose().copy(first.pose);
    this.all.forEach((viewport, i) => (viewport.element.hidden = i >= count));
    this.resize();
    return this.viewports;
  }

  /** Chooses the axis of space that is upward in all viewports. */
  upward(axis: "y" | "z"): void {
    for (const viewport of this.all) viewport.pose.upward = axis;
    for (const viewport of this.all) viewport.turned();
  }

  theme(theme: Theme): void {
    this.look.choose(theme);
    this.element.dataset.theme = theme;
    for (const viewport of this.all) viewport.redress();
    this.invalidate();
  }

  /** Draws now what else would be drawn soon; marks behind surfaces are hidden when it returns. */
  render(): void {
    this.draw(true);
  }

  /** Asks for a picture. */
  invalidate(pose?: Pose): void {
    if (pose) this.all.filter((viewport) => viewport.pose === pose).forEach((v) => v.tell());
    this.scheduled ||= requestAnimationFrame(() => this.draw(false));
  }

  /** Calls back when what was changed is with the graphics card; soon, where nothing is drawn. */
  whenDrawn(done: () => void): void {
    if (!this.scheduled) return done();
    if (this.waiting.push(done) === 1) setTimeout(() => this.drawn(), LONGEST_WAIT);
  }

  private drawn(): void {
    for (const done of this.waiting.splice(0)) done();
  }

  /** Shows all that viewports with a pose hold, about the middle of the first. */
  private fit(pose: Pose): void {
    const linked = this.viewports.filter((viewport) => viewport.pose === pose);
    const boxes = linked.map((viewport) => viewport.bounds()).filter((box) => !box.empty);
    if (boxes.length === 0) return;
    const middle = boxes[0]!.centre;
    pose.fit(middle, Math.max(...linked.map((viewport) => viewport.needed(middle))));
  }

  private resize(): void {
    const [width, height] = [this.container.clientWidth, this.container.clientHeight];
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio || 1, RATIO));
    this.renderer.setSize(width, height);
    const middle = this.shown === 2 ? Math.round(width / 2) : width;
    this.all[0]!.resize(0, middle, height);
    this.all[1]!.resize(middle, Math.max(0, width - middle), height);
    const poses = new Set(this.viewports.map((viewport) => viewport.pose));
    for (const pose of poses) if (pose.fitted) this.fit(pose);
    if (width > 0 && height > 0) this.draw(false);
  }

  private draw(settle: boolean): void {
    cancelAnimationFrame(this.scheduled);
    this.scheduled = 0;
    if (this.renderer.getContext().isContextLost()) return;
    const started = performance.now();
    const ratio = this.renderer.getPixelRatio();
    for (const viewport of this.viewports) {
      const { offsetLeft, offsetWidth, offsetHeight } = viewport.element;
      this.renderer.setViewport(offsetLeft, 0, offsetWidth, offsetHeight);
      this.renderer.setScissor(offsetLeft, 0, offsetWidth, offsetHeight);
      if (this.drawing) this.renderer.clear();
      viewport.render(this.renderer, ratio, this.drawing, settle);
    }
    this.stats.frames += 1;
    this.stats.draw = performance.now() - started;
    this.drawn();
  }

  private lost(event: Event): void {
    event.preventDefault();
    this.stats.lost += 1;
    this.notice.textContent =
      "The graphics card was taken away from this page. The picture comes back by itself; " +
      "if it does not, load the page anew: nothing is lost.";
    this.notice.hidden = false;
  }

  private restored(): void {
    this.notice.hidden = true;
    this.invalidate();
  }

  private key(event: KeyboardEvent): void {
    const viewport = this.viewports.find(({ element }) => element === event.target);
    if (!viewport || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === "f" || event.key === "F") viewport.frame();
    else if (event.key === "Escape") viewport.cancel();
  }

  dispose(): void {
    cancelAnimationFrame(this.scheduled);
    this.watch.disconnect();
    this.keys.abort();
    for (const viewport of this.all) viewport.dispose();
    this.renderer.dispose();
    this.element.remove();
  }
}
