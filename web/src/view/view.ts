/** A scene on the page: how it is seen now, and what is drawn of it. */

import { category, Stage, type Anchor, type Hit, type View as Camera } from "../viewer/index.ts";
import { slid, type Colouring, type Place, type Scene } from "./scene.ts";

export type Theme = "light" | "dark";

/** Of the surface in its viewport. */
const KEY = "surface";

/** Of a slide's way from one end to the other, while it plays. */
const SECONDS = 2.5;

/** Entries of a legend, at most. */
const MOST_LABELS = 14;

/** CSS colour of labels below 0, which mean that there is none. */
const NONE = "#b3bdc8";

const system = matchMedia("(prefers-color-scheme: dark)");

export class View {
  /** Number of the colouring that is seen, null for the surface's own colour. */
  shown: number | null;
  edges: boolean;
  shading: "smooth" | "flat" = "smooth";
  /** Of each slide. */
  values: number[];
  /** Number of the slide that plays. */
  playing: number | null = null;
  /** What is under the pointer, in words. */
  under = "";
  stage: Stage | null = null;
  private chosen: Theme | null = null;
  private seen: Camera | null = null;
  private frame = 0;
  private readonly listeners = new Set<() => void>();
  private readonly place = document.createElement("div");

  /** @param parent where the picture is put */
  constructor(
    readonly scene: Scene,
    parent: HTMLElement,
  ) {
    this.shown = scene.shown;
    this.edges = scene.edges;
    this.values = scene.slides.map(({ start }) => start);
    this.place.className = "view-place";
    parent.append(this.place);
    system.addEventListener("change", () => this.dress());
  }

  /** Calls back when something that controls show has changed. */
  subscribe(listener: () => void): void {
    this.listeners.add(listener);
  }

  private tell(): void {
    for (const listener of this.listeners) listener();
  }

  get theme(): Theme {
    return this.chosen ?? (system.matches ? "dark" : "light");
  }

  private get viewport() {
    return this.stage?.viewports[0];
  }

  private get surface() {
    return this.viewport?.surface(KEY);
  }

  /**
   * Draws, until {@link stop}.
   *
   * @throws Error if the browser has no WebGL 2
   */
  start(): void {
    if (this.stage) return;
    this.stage = new Stage(this.place);
    this.place.style.backgroundImage = "";
    const { scene } = this;
    const viewport = this.viewport!;
    this.stage.upward(scene.upward);
    viewport.add(KEY, scene.surface, { edges: this.edges, shading: this.shading });
    viewport.title(scene.title);
    viewport.marks.set(
      scene.marks.map(({ label, colour, place }, k) => ({
        id: String(k),
        label,
        colour: colour ?? category(k),
        position: anchor(place),
      })),
    );
    viewport.lines.set(
      scene.lines.map(({ colour, places, closed, width }, k) => ({
        id: String(k),
        colour: colour ?? category(k),
        points: places.map(anchor),
        closed,
        width,
      })),
    );
    viewport.on("hover", (hit) => this.hover(hit));
    this.bring();
    this.dress();
    if (this.seen) viewport.look(this.seen);
    else if (scene.side) viewport.view(scene.side);
    if (!this.seen) viewport.frame();
    this.stage.render();
  }

  /** Leaves a picture, and gives the graphics card back: a browser has few to lend. */
  stop(): void {
    const { stage } = this;
    if (!stage) return;
    this.pause();
    this.seen = this.viewport!.camera();
    stage.render();
    const canvas = this.place.querySelector("canvas")!;
    this.place.style.backgroundImage = `url(${canvas.toDataURL()})`;
    stage.dispose();
    canvas.getContext("webgl2")?.getExtension("WEBGL_lose_context")?.loseContext();
    this.stage = null;
  }

  /** Chooses the colouring by its number, null for none. */
  show(colouring: number | null): void {
    this.shown = colouring;
    this.paint();
    this.tell();
  }

  setEdges(edges: boolean): void {
    this.edges = edges;
    this.surface?.style({ edges });
    this.tell();
  }

  setShading(shading: "smooth" | "flat"): void {
    this.shading = shading;
    this.surface?.style({ shading });
    this.tell();
  }

  setTheme(theme: Theme): void {
    this.chosen = theme;
    this.dress();
  }

  private dress(): void {
    document.documentElement.dataset.theme = this.theme;
    this.stage?.theme(this.theme);
    this.paint();
    this.tell();
  }

  private paint(): void {
    const { surface, viewport } = this;
    if (!surface || !viewport) return;
    const one = this.shown === null ? null : this.scene.colourings[this.shown]!;
    const { colours, legend } = one ? painted(one) : { colours: null, legend: null };
    surface.colours(colours);
    viewport.legend.set(legend);
  }

  /** Moves one slide. */
  slide(which: number, value: number): void {
    this.values = this.values.map((before, k) => (k === which ? value : before));
    this.bring();
    this.tell();
  }

  /** Brings the surface to where the slides are. */
  private bring(): void {
    const { slides, surface } = this.scene;
    if (slides.length === 0) return;
    this.surface?.setPositions(slid(surface.positions, slides, this.values));
  }

  /** Lets a slide run to and fro. */
  play(which: number): void {
    this.pause();
    const { from: low, to: high } = this.scene.slides[which]!;
    let direction = this.values[which]! < high ? 1 : -1;
    let last = performance.now();
    const step = (now: number) => {
      this.frame = requestAnimationFrame(step);
      const passed = Math.min(Math.max(0, now - last) / 1000 / SECONDS, 1);
      last = now;
      let value = this.values[which]! + direction * passed * (high - low);
      if (value > high || value < low) {
        value = Math.max(low, Math.min(high, direction > 0 ? 2 * high - value : 2 * low - value));
        direction = -direction;
      }
      this.slide(which, value);
    };
    this.playing = which;
    this.frame = requestAnimationFrame(step);
    this.tell();
  }

  pause(): void {
    cancelAnimationFrame(this.frame);
    this.playing = null;
    this.tell();
  }

  private hover(hit: Hit | null): void {
    const under = hit ? this.words(hit) : "";
    if (under === this.under) return;
    this.under = under;
    this.tell();
  }

  private words({ vertex, face }: Hit): string {
    const one = this.shown === null ? null : this.scene.colourings[this.shown]!;
    const value = one ? valueOf(one, one.per === "face" ? face : vertex) : "";
    return [`vertex ${vertex}`, `face ${face}`, value].filter(Boolean).join(" · ");
  }
}

const anchor = (place: Place): Anchor =>
  typeof place === "number" ? { surface: KEY, vertex: place } : place;

/** The value that a vertex or face has, in words. */
function valueOf({ kind, values, labels }: Colouring, index: number): string {
  if (kind === "rgb") return "";
  const value = values[index]!;
  if (Number.isNaN(value)) return "no value";
  return (
    labels.find((label) => label.value === value)?.name ?? String(Number(value.toPrecision(5)))
  );
}

/** Colours of a surface, and their legend. */
function painted(one: Colouring) {
  const { name, per, kind, values, colormap, min, max, labels } = one;
  if (kind === "rgb") return { colours: { rgb: Uint8Array.from(values), per }, legend: null };
  if (kind === "values" && colormap !== "categorical")
    return {
      colours: { values, per, colormap, min, max },
      legend: { title: name, min, max, colormap },
    };
  const ranks = new Map(labels.filter(({ value }) => value >= 0).map(({ value }, k) => [value, k]));
  const rank = (value: number) => ranks.get(value) ?? value;
  const entries = labels.slice(0, MOST_LABELS).map(({ value, name: label }) => ({
    label,
    colour: value < 0 ? NONE : category(rank(value)),
  }));
  const left = labels.length - entries.length;
  if (left > 0) entries.push({ label: `and ${left} more`, colour: "transparent" });
  return {
    colours: { values: values.map(rank), per, colormap: "categorical" as const, min, max },
    legend: entries.length > 0 ? { title: name, entries } : null,
  };
}
