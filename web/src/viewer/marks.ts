/** Dots with labels over a viewport, hidden where they are behind a surface. */
import type { Sight } from "./sight";
import type { SurfaceView } from "./surface";
import { anchored, hiddenBy } from "./targets";
import type { Anchor } from "./types";
import type { Frame } from "./vectors";

export interface Mark {
  id: string;
  label?: string;
  /** CSS colour. */
  colour?: string;
  position: Anchor;
  selected?: boolean;
}

/** What marks need to know of their viewport. */
export interface Surroundings {
  surfaces: readonly SurfaceView[];
  sight: Sight;
  frame: Frame;
}

/** Milliseconds up to which hiding is found at every picture; above, when all is still. */
const QUICK = 6;
const STILL = 90;

/** Pixels around a mark that belong to it. */
const REACH = 9;

interface Shown {
  mark: Mark;
  element: HTMLElement;
  x: number;
  y: number;
  hidden: boolean;
}

export class Marks {
  private readonly element = document.createElement("div");
  private shown: Shown[] = [];
  private cost = 0;
  private waiting = 0;

  /**
   * @param parent where the marks are put
   * @param around the viewport as it is now
   */
  constructor(
    parent: HTMLElement,
    private readonly around: () => Surroundings,
    private readonly changed: () => void,
  ) {
    this.element.className = "viewer-marks";
    parent.append(this.element);
  }

  /** Shows these marks and no others. */
  set(marks: readonly Mark[]): void {
    const known = new Map(this.shown.map((shown) => [shown.mark.id, shown]));
    this.shown = marks.map((mark) => {
      const before = known.get(mark.id);
      known.delete(mark.id);
      const element = before?.element ?? this.made();
      dress(element, mark);
      const { x, y, hidden } = before ?? { x: NaN, y: NaN, hidden: true };
      return { mark, element, x, y, hidden };
    });
    for (const { element } of known.values()) element.remove();
    this.changed();
  }

  private made(): HTMLElement {
    const element = document.createElement("div");
    element.className = "viewer-mark";
    element.append(document.createElement("i"), document.createElement("span"));
    this.element.append(element);
    return element;
  }

  /** Id of the visible mark at a pixel of the viewport. */
  at(x: number, y: number): string | null {
    let found: string | null = null;
    let least = REACH;
    for (const shown of this.shown) {
      const apart = Math.hypot(shown.x - x, shown.y - y);
      if (!shown.hidden && apart <= least) {
        least = apart;
        found = shown.mark.id;
      }
    }
    return found;
  }

  /** Puts the marks where they are now; those behind go, at once if `settle` or if it is quick. */
  update(settle: boolean): void {
    if (this.shown.length === 0) return;
    this.place();
    window.clearTimeout(this.waiting);
    if (settle || this.cost < QUICK) this.conceal();
    else this.waiting = window.setTimeout(() => this.conceal(), STILL);
  }

  private place(): void {
    const { surfaces, sight, frame } = this.around();
    for (const shown of this.shown) {
      const point = anchored(shown.mark.position, surfaces, frame);
      const [x, y, depth] = point ? sight.project(point) : [NaN, NaN, -1];
      shown.x = x;
      shown.y = y;
      const beyond = !(depth > 0 && x >= 0 && y >= 0 && x <= sight.width && y <= sight.height);
      shown.element.classList.toggle("viewer-beyond", beyond);
      if (!beyond)
        shown.element.style.transform = `translate(${x.toFixed(2)}px, ${y.toFixed(2)}px)`;
    }
  }

  private conceal(): void {
    const { surfaces, sight, frame } = this.around();
    const solid = surfaces.filter((surface) => surface.solid);
    const anchors = this.shown.map(({ mark }) => mark.position);
    const started = performance.now();
    const hidden = hiddenBy(solid, sight, anchors, frame);
    this.cost = performance.now() - started;
    this.shown.forEach((shown, i) => {
      shown.hidden = hidden[i] === 1 || shown.element.classList.contains("viewer-beyond");
      shown.element.classList.toggle("viewer-hidden", shown.hidden);
    });
  }

  dispose(): void {
    window.clearTimeout(this.waiting);
    this.element.remove();
  }
}

function dress(element: HTMLElement, { id, label, colour, selected }: Mark): void {
  element.dataset.mark = id;
  element.style.setProperty("--mark", colour ?? "");
  element.classList.toggle("viewer-selected", selected ?? false);
  const text = element.lastElementChild as HTMLElement;
  text.textContent = label ?? "";
  text.hidden = !label;
}
