/** Light and dark. */
import { Color, Vector3 } from "three";
import type { Eye } from "./pose";
import type { Theme } from "./types";
import { add, dot, scaled } from "./vectors";

interface Palette {
  /** CSS colours. */
  clay: string;
  edges: string;
  creases: string;
  /** Light from above, from below and from the key light, linear. */
  sky: [number, number, number];
  ground: [number, number, number];
  sun: [number, number, number];
  /** What the clay is multiplied with on the inner side. */
  inside: [number, number, number];
}

const PALETTES: Record<Theme, Palette> = {
  light: {
    clay: "#bcc7d3",
    edges: "#1d2733",
    creases: "#141c26",
    sky: [0.5, 0.53, 0.58],
    ground: [0.2, 0.19, 0.19],
    sun: [0.86, 0.83, 0.78],
    inside: [0.82, 0.66, 0.55],
  },
  dark: {
    clay: "#aab4c0",
    edges: "#0a0e13",
    creases: "#05080c",
    sky: [0.4, 0.44, 0.5],
    ground: [0.11, 0.11, 0.13],
    sun: [0.86, 0.84, 0.79],
    inside: [0.78, 0.6, 0.48],
  },
};

/** Fixed to the camera, with a little of what is fixed in space. */
const KEY = { camera: [-0.45, 0.6, 0.75], space: [0.3, 0.8, 0.5], share: 0.25 } as const;

const uniform = <Value>(value: Value) => ({ value });

/** The colours and lights that all surfaces of a stage share, as uniforms. */
export class Look {
  palette = PALETTES.light;
  readonly lights = {
    key: uniform(new Vector3(0, 0, 1)),
    upward: uniform(new Vector3(0, 1, 0)),
    sky: uniform(new Vector3()),
    ground: uniform(new Vector3()),
    sun: uniform(new Vector3()),
    inside: uniform(new Vector3()),
  };

  constructor(theme: Theme) {
    this.choose(theme);
  }

  choose(theme: Theme): void {
    this.palette = PALETTES[theme];
    const { sky, ground, sun, inside } = this.palette;
    this.lights.sky.value.fromArray(sky);
    this.lights.ground.value.fromArray(ground);
    this.lights.sun.value.fromArray(sun);
    this.lights.inside.value.fromArray(inside);
  }

  /** Lets the lights follow a camera; the shaders want them as the camera sees them. */
  follow(eye: Eye, upward: "y" | "z"): void {
    const up: [number, number, number] = upward === "y" ? [0, 1, 0] : [0, 0, 1];
    const back = scaled(eye.ahead, -1);
    const seen = (v: [number, number, number]): [number, number, number] => [
      dot(v, eye.right),
      dot(v, eye.up),
      dot(v, back),
    ];
    const space = seen([...KEY.space]);
    const key = add(scaled([...KEY.camera], 1 - KEY.share), scaled(space, KEY.share));
    this.lights.key.value.fromArray(key).normalize();
    this.lights.upward.value
      .fromArray(seen(up))
      .lerp(new Vector3(0, 1, 0), 0.35)
      .normalize();
  }
}

/** Sets a colour to a CSS colour's own numbers, not made linear. */
export function plain(colour: Color, css: string): Color {
  const { r, g, b } = new Color(css).convertLinearToSRGB();
  return colour.setRGB(r, g, b);
}

/** Red, green and blue of a CSS colour, 0 to 255. */
export function bytes(css: string): [number, number, number] {
  const { r, g, b } = plain(new Color(), css);
  return [r, g, b].map((part) => Math.round(255 * part)) as [number, number, number];
}
