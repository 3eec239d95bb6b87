/** Where the eye is: a turntable about a target, in the coordinates of a viewport's scene. */
import type { Point, Side } from "./types";
import { add, dot, scaled, subtract } from "./vectors";

/** Degrees from the bottom to the top of the picture. */
export const FIELD_OF_VIEW = 35;

/** Half the picture's height, one unit ahead. */
export const SLOPE = Math.tan((FIELD_OF_VIEW / 2) * (Math.PI / 180));

const CLOSEST = 1e-4;
const FARTHEST = 1e3;

/** Of the picture, which is left free around what is fitted into it. */
const MARGIN = 0.1;

/** Azimuth and elevation, in quarter turns. */
const SIDES: Record<Side, [number, number]> = {
  front: [0, 0],
  right: [1, 0],
  back: [2, 0],
  left: [-1, 0],
  top: [0, 1],
  bottom: [0, -1],
};

/** Unit vectors to the right, up and ahead, and the eye. */
export interface Eye {
  position: Point;
  right: Point;
  up: Point;
  ahead: Point;
}

/** A camera's target, distance and direction; linked viewports share one. */
export class Pose {
  target: Point = [0, 0, 0];
  distance = 1.1 / SLOPE;
  /** Radians about the upward axis, from the front. */
  azimuth = 0.5;
  /** Radians above the horizon. */
  elevation = 0.25;
  /** The upward axis of space. */
  upward: "y" | "z" = "y";
  /** Nobody has gone nearer or aside since all was fitted into the picture. */
  fitted = true;

  copy(other: Pose): this {
    return Object.assign(this, other, { target: [...other.target] });
  }

  eye(): Eye {
    const [s, c] = [Math.sin(this.azimuth), Math.cos(this.azimuth)];
    const [se, ce] = [Math.sin(this.elevation), Math.cos(this.elevation)];
    const back = this.stood([s * ce, se, c * ce]);
    return {
      position: add(this.target, scaled(back, this.distance)),
      right: this.stood([c, 0, -s]),
      up: this.stood([-s * se, ce, -c * se]),
      ahead: scaled(back, -1),
    };
  }

  /** Turns by radians to the right and upward; the upward axis stays upward. */
  orbit(right: number, up: number): void {
    const quarter = Math.PI / 2;
    this.azimuth = (this.azimuth + right) % (2 * Math.PI);
    this.elevation = Math.max(-quarter, Math.min(quarter, this.elevation + up));
  }

  /** Moves sideways, by fractions of the picture's height at the target. */
  pan(right: number, up: number): void {
    this.fitted = false;
    const eye = this.eye();
    const height = 2 * SLOPE * this.distance;
    this.target = add(this.target, scaled(eye.right, right * height));
    this.target = add(this.target, scaled(eye.up, up * height));
  }

  /** Goes nearer to a point (factor below 1) or away from it; it stays where it is seen. */
  zoom(factor: number, about: Point): void {
    const distance = Math.max(CLOSEST, Math.min(FARTHEST, this.distance * factor));
    const real = distance / this.distance;
    this.fitted = false;
    this.target = add(about, scaled(subtract(this.target, about), real));
    this.distance = distance;
  }

  look(side: Side): void {
    const [azimuth, elevation] = SIDES[side];
    this.azimuth = (azimuth * Math.PI) / 2;
    this.elevation = (elevation * Math.PI) / 2;
  }

  /** Looks at a point from as near as the needed distance, of {@link needed}, allows. */
  fit(centre: Point, distance: number): void {
    this.target = [...centre];
    this.distance = Math.max(CLOSEST, distance);
    this.fitted = true;
  }

  /** Looks from a point at another, as far as a turntable can. */
  place(position: Point, target: Point): void {
    const back = this.laid(subtract(position, target));
    this.target = target;
    this.fitted = false;
    this.distance = Math.max(CLOSEST, Math.sqrt(dot(back, back)));
    this.azimuth = Math.atan2(back[0], back[2]);
    this.elevation = Math.asin(Math.max(-1, Math.min(1, back[1] / this.distance)));
  }

  private stood([x, y, z]: Point): Point {
    return this.upward === "y" ? [x, y, z] : [x, -z, y];
  }

  private laid([x, y, z]: Point): Point {
    return this.upward === "y" ? [x, y, z] : [x, z, -y];
  }
}

/**
 * The distance from a target from which all positions (n, 3) are in the picture.
 *
 * @param eye whose direction counts
 * @param used (n,) whether a vertex counts
 */
export function needed(
  positions: Float32Array,
  used: Uint8Array,
  eye: Eye,
  target: Point,
  aspect: number,
): number {
  const [tx, ty, tz] = target;
  const slope = SLOPE * (1 - MARGIN);
  const [rx, ry, rz] = scaled(eye.right, 1 / (slope * aspect));
  const [ux, uy, uz] = scaled(eye.up, 1 / slope);
  const [ax, ay, az] = eye.ahead;
  let distance = 0;
  for (let vertex = 0, i = 0; vertex < used.length; vertex++, i += 3) {
    if (!used[vertex]) continue;
    const x = positions[i]! - tx;
    const y = positions[i + 1]! - ty;
    const z = positions[i + 2]! - tz;
    const aside = Math.max(Math.abs(x * rx + y * ry + z * rz), Math.abs(x * ux + y * uy + z * uz));
    const from = aside - (x * ax + y * ay + z * az);
    if (from > distance) distance = from;
  }
  return distance;
}
