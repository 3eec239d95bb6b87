/** Rectangles and lassos drawn over a viewport. */
import type { Drag } from "./pointer";

/** Pixels between corners of a lasso, and from one end of a rectangle to the other at least. */
const SPACING = 2;
const SMALLEST = 4;

const SVG = "http://www.w3.org/2000/svg";

/** An element over a viewport, for shapes in its pixels. */
export function sheet(parent: HTMLElement): SVGSVGElement {
  const element = document.createElementNS(SVG, "svg");
  element.classList.add("viewer-sheet");
  parent.append(element);
  return element;
}

export function shape(parent: SVGElement, tag: string, name: string): SVGElement {
  const element = document.createElementNS(SVG, tag);
  element.classList.add(name);
  parent.append(element);
  return element;
}

/** A drag that draws; `done` gets the corners in pixels of the viewport. */
export function outlining(
  kind: "rectangle" | "lasso",
  parent: SVGElement,
  start: [number, number],
  done: (corners: [number, number][], event: PointerEvent) => void,
): Drag {
  const path = shape(parent, "path", "viewer-outline");
  let corners: [number, number][] = [start];
  return {
    move(x, y) {
      if (kind === "rectangle") corners = [start, [x, start[1]], [x, y], [start[0], y]];
      else lengthen(corners, x, y);
      path.setAttribute("d", `M${corners.map((corner) => corner.join(" ")).join("L")}Z`);
    },
    end(event) {
      path.remove();
      if (corners.length > 2 && extent(corners) >= SMALLEST) done(corners, event);
    },
    cancel: () => path.remove(),
  };
}

function lengthen(corners: [number, number][], x: number, y: number): void {
  const [px, py] = corners[corners.length - 1]!;
  if (Math.hypot(x - px, y - py) >= SPACING) corners.push([x, y]);
}

function extent(corners: [number, number][]): number {
  const spread = (values: number[]) => Math.max(...values) - Math.min(...values);
  return Math.max(spread(corners.map(([x]) => x)), spread(corners.map(([, y]) => y)));
}
