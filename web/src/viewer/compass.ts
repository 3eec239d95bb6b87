/** The directions of the axes, in a corner. */
import { shape } from "./outline";
import type { Eye } from "./pose";
import type { Point } from "./types";

const AXES: { name: string; axis: number; colour: string }[] = [
  { name: "x", axis: 0, colour: "#d9485a" },
  { name: "y", axis: 1, colour: "#4f9d4b" },
  { name: "z", axis: 2, colour: "#3f7fd6" },
];

const SIZE = 56;
const ARM = 17;

export class Compass {
  private readonly element = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  private readonly arms: { line: SVGElement; letter: SVGElement; axis: number }[];
  private turned = "";

  constructor(parent: HTMLElement) {
    this.element.classList.add("viewer-compass");
    this.element.setAttribute("viewBox", `${-SIZE / 2} ${-SIZE / 2} ${SIZE} ${SIZE}`);
    this.element.setAttribute("aria-hidden", "true");
    this.arms = AXES.map(({ name, axis, colour }) => {
      const line = shape(this.element, "line", "viewer-arm");
      const letter = shape(this.element, "text", "viewer-letter");
      line.setAttribute("stroke", colour);
      letter.setAttribute("fill", colour);
      letter.textContent = name;
      return { line, letter, axis };
    });
    parent.append(this.element);
  }

  /** Turns as the scene is seen; arms toward the eye are over those away from it. */
  turn({ right, up, ahead }: Eye): void {
    const now = [right, up, ahead].join();
    if (now === this.turned) return;
    this.turned = now;
    const depth = (axis: number) => (ahead as Point)[axis]!;
    for (const { line, letter, axis } of this.arms) {
      const [x, y] = [right[axis]! * ARM, -up[axis]! * ARM];
      line.setAttribute("x2", x.toFixed(1));
      line.setAttribute("y2", y.toFixed(1));
      letter.setAttribute("x", (1.45 * x).toFixed(1));
      letter.setAttribute("y", (1.45 * y).toFixed(1));
      const opacity = depth(axis) > 0.3 ? "0.45" : "1";
      line.setAttribute("opacity", opacity);
      letter.setAttribute("opacity", opacity);
    }
    const order = [...this.arms].sort((p, q) => depth(q.axis) - depth(p.axis));
    this.element.append(...order.flatMap(({ line, letter }) => [line, letter]));
  }
}
