/** Colours of numbers. */
import {
  ClampToEdgeWrapping,
  DataTexture,
  LinearFilter,
  RGBAFormat,
  UnsignedByteType,
} from "three";
import { bytes } from "./themes";

export type Colormap = "viridis" | "magma" | "heat" | "coolwarm" | "quality" | "categorical";

/** Colours at equal steps, from the lowest value to the highest. */
const STOPS: Record<Exclude<Colormap, "categorical">, string[]> = {
  viridis: [
    "#440154",
    "#482475",
    "#414487",
    "#355f8d",
    "#2a788e",
    "#21918c",
    "#22a884",
    "#44bf70",
    "#7ad151",
    "#bddf26",
    "#fde725",
  ],
  magma: ["#0b0924", "#231151", "#5f187f", "#982d80", "#d3436e", "#f8765c", "#febb81", "#fcfdbf"],
  heat: ["#e6ebf0", "#f3e6bd", "#f6c77e", "#ee9355", "#d65445", "#a72344", "#6b1139"],
  coolwarm: [
    "#3b4cc0",
    "#5a78e4",
    "#7b9ff9",
    "#9ebeff",
    "#c0d4f5",
    "#dddcdc",
    "#f2cbb7",
    "#f7ac8e",
    "#ee8468",
    "#d65244",
    "#b40426",
  ],
  quality: ["#b3263b", "#e06d4f", "#f3b279", "#f4e5b4", "#a9d4b0", "#57a99a", "#1f7a83"],
};

/** Told apart side by side, and calm enough for large patches. */
const CATEGORIES = [
  "#6b9bd1",
  "#e8a15c",
  "#73b788",
  "#d4797f",
  "#9d8cc9",
  "#b8966f",
  "#e3a5c4",
  "#8fa3ad",
  "#c9c16b",
  "#6dbcc4",
  "#b5d29c",
  "#d0a2e0",
  "#f0c48f",
  "#7f93d6",
  "#c98f9d",
  "#9fb36a",
];

const STEPS = 256;

const tables = new Map<string, Uint8Array>();
const textures = new Map<string, DataTexture>();

/** (256, 4) bytes of a continuous colour map. */
function table(colormap: Exclude<Colormap, "categorical">): Uint8Array {
  const known = tables.get(colormap);
  if (known) return known;
  const stops = STOPS[colormap].map(bytes);
  const filled = new Uint8Array(4 * STEPS).fill(255);
  for (let i = 0; i < STEPS; i++) {
    const at = (i / (STEPS - 1)) * (stops.length - 1);
    const below = Math.min(Math.floor(at), stops.length - 2);
    for (let k = 0; k < 3; k++) {
      const [low, high] = [stops[below]![k]!, stops[below + 1]![k]!];
      filled[4 * i + k] = Math.round(low + (high - low) * (at - below));
    }
  }
  tables.set(colormap, filled);
  return filled;
}

/** A colour map as a texture of one row, shared by all who ask. */
export function textureOf(colormap: Exclude<Colormap, "categorical">): DataTexture {
  const known = textures.get(colormap);
  if (known) return known;
  const texture = new DataTexture(table(colormap), STEPS, 1, RGBAFormat, UnsignedByteType);
  texture.magFilter = texture.minFilter = LinearFilter;
  texture.wrapS = texture.wrapT = ClampToEdgeWrapping;
  texture.needsUpdate = true;
  textures.set(colormap, texture);
  return texture;
}

/** The CSS colour of a category (a whole number, of a patch say). */
export function category(index: number): string {
  const count = CATEGORIES.length;
  return CATEGORIES[((index % count) + count) % count]!;
}

/** Where values are between two limits: 0 to 1, and -1 for those that are no numbers. */
export function shares(values: ArrayLike<number>, min: number, max: number): Float32Array {
  const found = new Float32Array(values.length);
  const range = max > min ? max - min : 1;
  for (let i = 0; i < values.length; i++) {
    const value = values[i]!;
    found[i] = Number.isNaN(value) ? -1 : Math.max(0, Math.min(1, (value - min) / range));
  }
  return found;
}

/** Colours (k, 3) of values, in bytes; `blank` for those that are no numbers. */
export function coloured(
  values: ArrayLike<number>,
  colormap: Colormap,
  min: number,
  max: number,
  blank: [number, number, number],
): Uint8Array {
  if (colormap === "categorical") return categorised(values, blank);
  const colours = new Uint8Array(3 * values.length);
  const known = table(colormap);
  shares(values, min, max).forEach((share, i) => {
    const at = 4 * Math.round(share * (STEPS - 1));
    for (let k = 0; k < 3; k++) colours[3 * i + k] = share < 0 ? blank[k]! : known[at + k]!;
  });
  return colours;
}

function categorised(values: ArrayLike<number>, blank: [number, number, number]): Uint8Array {
  const colours = new Uint8Array(3 * values.length);
  const palette = CATEGORIES.map(bytes);
  for (let i = 0; i < values.length; i++) {
    const index = Math.round(values[i]!);
    const known = index >= 0 ? palette[index % palette.length]! : blank;
    colours.set(known, 3 * i);
  }
  return colours;
}

/** A continuous colour map as a CSS gradient. */
export function gradient(colormap: Exclude<Colormap, "categorical">, direction: string): string {
  return `linear-gradient(${direction}, ${STOPS[colormap].join(", ")})`;
}
