/** What is drawn over the surface: pins, lines, and the vertices of the cage. */

import type { Anchor, Mark, Point, PolyLine, Viewport } from "../../viewer/index.ts";
import { type Drag, SURFACE } from "./drag.ts";
import { colourOf, own, type Placed } from "./state.ts";

/** Points of a line that have marks, at most. */
const MOST_POINTS = 80;

/** Vertices of the cage up to which all have marks, and not only those that are let go. */
const MOST_VERTICES = 500;

const HELD = "#6b7280";
const FREE = "#e0661f";

/** All that there is to be drawn. */
export interface Picture {
  placed: readonly Placed[];
  drag: Drag | null;
  /** Vertices of the curve that is being drawn: all, and those that were clicked. */
  drawn: { level: number; path: readonly number[]; through: readonly number[] } | null;
  /** Of the cage, while they can be clicked. */
  cage: { count: number; free: ReadonlySet<number> } | null;
  hover: { vertex: number; colour: string } | null;
}

export const markOf = (name: string) => `at ${name}`;
export const pointMark = (index: number) => `point ${index}`;

/** What a mark stands for; null for one that is only to be seen. */
export function meantBy(mark: string): { name: string } | { index: number } | null {
  const [, kind, what] = /^(at|point) (.*)$/s.exec(mark) ?? [];
  if (kind === "at") return { name: what! };
  return kind === "point" ? { index: Number(what) } : null;
}

export function draw(viewport: Viewport, picture: Picture): void {
  viewport.marks.set(marks(picture));
  viewport.lines.set(lines(picture));
}

const on = (vertex: number): Anchor => ({ surface: SURFACE, vertex });

/** Where the line of a constraint is, in the middle of a drag too. */
function lineNow({ line, part }: Placed, drag: Drag | null): readonly Point[] {
  return drag?.placed.part.name === part.name ? drag.line : line;
}

function marks({ placed, drag, drawn, cage, hover }: Picture): Mark[] {
  const found: Mark[] = [];
  for (const one of placed) {
    const { name, level, kind } = one.part;
    const line = lineNow(one, drag);
    if (line.length === 0) continue;
    const selected = own.chosen === name;
    const colour = colourOf(level);
    const middle = kind === "pins" ? 0 : Math.floor(line.length / 2);
    const label = selected || placed.length <= 40 ? name : "";
    const whole = selected && own.point === null;
    found.push({ id: markOf(name), label, colour, position: line[middle]!, selected: whole });
    if (kind === "curves" && selected) found.push(...pointsOf(line, middle, colour));
  }
  drawn?.through.forEach((vertex, k) => {
    const closes = k === 0 && drawn.through.length > 2;
    const label = closes ? "click to close" : "";
    found.push({ id: `stroke ${k}`, label, colour: colourOf(drawn.level), position: on(vertex) });
  });
  if (cage) found.push(...cageMarks(cage));
  if (hover) found.push({ id: "hover", colour: hover.colour, position: on(hover.vertex) });
  return found;
}

function pointsOf(line: readonly Point[], middle: number, colour: string): Mark[] {
  const step = Math.ceil(line.length / MOST_POINTS);
  return line.flatMap((position, k) => {
    const selected = own.point === k;
    if (k === middle || (k % step !== 0 && !selected)) return [];
    return [{ id: pointMark(k), colour, position, selected }];
  });
}

function cageMarks({ count, free }: { count: number; free: ReadonlySet<number> }): Mark[] {
  const all = count <= MOST_VERTICES ? [...Array(count).keys()] : [...free];
  return all.map((vertex) => ({
    id: `cage ${vertex}`,
    colour: free.has(vertex) ? FREE : HELD,
    position: on(vertex),
  }));
}

function lines({ placed, drag, drawn }: Picture): PolyLine[] {
  const found: PolyLine[] = [];
  for (const one of placed) {
    const { name, level, kind } = one.part;
    const line = lineNow(one, drag);
    if (line.length === 0) continue;
    const colour = colourOf(level);
    const chosen = own.chosen === name;
    if (kind === "curves") {
      found.push({ id: `line ${name}`, colour, points: line, width: chosen ? 4 : 2.5 });
      if (chosen) found.push({ id: `path ${name}`, colour, points: one.path.map(on), width: 1.2 });
    } else if (one.path.length > 0) {
      found.push({ id: `way ${name}`, colour, points: [on(one.path[0]!), line[0]!], width: 1.5 });
    }
  }
  if (drawn) {
    const points = drawn.path.map(on);
    found.push({ id: "stroke", colour: colourOf(drawn.level), points, width: 3 });
  }
  return found;
}
