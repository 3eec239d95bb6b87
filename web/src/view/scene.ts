/** What a page shows, read from the bytes that `henkei.io.html` packed. */

import type { Colormap, Point, Side, SurfaceData } from "../viewer/index.ts";
import { outlines } from "./outlines.ts";

/** Colours that can be chosen. */
export interface Colouring {
  name: string;
  per: "vertex" | "face";
  kind: "values" | "labels" | "rgb";
  colormap: Colormap;
  /** Ends of the colour map. */
  min: number;
  max: number;
  /** (n,) or (faces,); NaN where there is none. Of rgb, (n, 3) or (faces, 3), 0 to 255. */
  values: Float64Array;
  /** Of labels, those there are. */
  labels: { value: number; name: string }[];
}

/** One way in which the shape may be moved. */
export interface Slide {
  name: string;
  from: number;
  to: number;
  start: number;
  /** What its ends are called. */
  ends: [string, string] | null;
  /** (n, 3), added once for a value of 1. */
  move: Float32Array;
}

/** A vertex, or a point in space. */
export type Place = number | Point;

export interface Scene {
  title: string;
  upward: "y" | "z";
  side: Side | null;
  edges: boolean;
  surface: SurfaceData;
  colourings: Colouring[];
  /** Number of the colouring that is seen first, null for none. */
  shown: number | null;
  slides: Slide[];
  marks: { label: string; colour: string | null; place: Place }[];
  lines: { colour: string | null; places: Place[]; closed: boolean; width: number }[];
}

/** An array of whole numbers: its rows, its columns, and bytes of each number as it is packed. */
type Shape = [rows: number, columns: number, width: number];

/** Of numbers that are `low + step * code`, by column. */
interface Steps {
  low: number[];
  step: number;
}

type Header = Omit<Scene, "surface" | "colourings" | "slides"> & {
  arrays: Record<string, Shape>;
  positions: Steps;
  centre: Point;
  scale: number;
  colourings: (Omit<Colouring, "values"> & Steps)[];
  slides: (Omit<Slide, "move"> & Steps)[];
};

/** Degrees between faces from which on their edge is a crease. */
const CREASE = 40;

/** Steps of rounding that are the height of a triangle whose direction says nothing. */
const THIN = 8;

/** Reads a scene. */
export function sceneOf(bytes: ArrayBuffer): Scene {
  const length = new DataView(bytes).getUint32(0, true);
  const text = new TextDecoder().decode(new Uint8Array(bytes, 4, length));
  const { arrays, positions, centre, scale, ...header } = JSON.parse(text) as Header;
  const codes = codesOf(new Uint8Array(bytes, 4 + length), arrays);
  const whole = (name: string) => codes[name] && new Uint32Array(codes[name].buffer);
  const triangles = whole("triangles")!;
  const face = whole("face");
  const places = stepped(codes.positions!, positions);
  const slides = header.slides.map((one, k) => ({
    ...one,
    move: stepped(codes[`slide ${k}`]!, one),
  }));
  const seen = slid(places, slides);
  const drawn = outlines(seen, triangles, face, CREASE, THIN * positions.step);
  return {
    ...header,
    surface: {
      positions: places,
      triangles,
      face,
      edges: drawn.edges,
      creases: whole("creases") ?? drawn.creases,
      centre,
      scale,
    },
    colourings: header.colourings.map((one, k) => ({
      ...one,
      values: valued(codes[`colouring ${k}`]!, one),
    })),
    slides,
  };
}

/** Positions (n, 3) with slides at these values; by default where they start. */
export function slid(
  positions: Float32Array,
  slides: readonly Slide[],
  values = slides.map(({ start }) => start),
): Float32Array {
  const moved = positions.slice();
  slides.forEach(({ move }, k) => {
    const value = values[k]!;
    if (value === 0) return;
    for (let i = 0; i < moved.length; i++) moved[i]! += value * move[i]!;
  });
  return moved;
}

/**
 * Arrays (rows, columns) of whole numbers by name.
 *
 * Of each, column after column, the change from the row before is packed: as a number without sign
 * (0, -1, 1, -2, ...), the low bytes of all first.
 */
function codesOf(bytes: Uint8Array, shapes: Record<string, Shape>): Record<string, Int32Array> {
  const found: Record<string, Int32Array> = {};
  let first = 0;
  for (const [name, [rows, columns, width]] of Object.entries(shapes)) {
    const size = rows * columns;
    const codes = new Int32Array(size);
    for (let column = 0, i = first; column < columns; column++) {
      let code = 0;
      for (let row = 0; row < rows; row++, i++) {
        let packed = 0;
        for (let k = 0; k < width; k++) packed |= bytes[i + k * size]! << (8 * k);
        code += (packed >>> 1) ^ -(packed & 1);
        codes[row * columns + column] = code;
      }
    }
    found[name] = codes;
    first += size * width;
  }
  return found;
}

/** The numbers that codes stand for. */
function stepped(codes: Int32Array, { low, step }: Steps): Float32Array {
  const columns = low.length;
  const numbers = new Float32Array(codes.length);
  for (let column = 0; column < columns; column++) {
    const first = low[column]!;
    for (let i = column; i < codes.length; i += columns) numbers[i] = first + step * codes[i]!;
  }
  return numbers;
}

/** The values that codes (k,) stand for; NaN for code -1. */
function valued(codes: Int32Array, { low, step }: Steps): Float64Array {
  const values = new Float64Array(codes.length);
  for (let i = 0; i < codes.length; i++)
    values[i] = codes[i] === -1 ? NaN : low[i % low.length]! + step * codes[i]!;
  return values;
}
