/** A viewport's camera in the coordinates of one surface, in doubles: what is where on the screen. */
import { SLOPE, type Eye } from "./pose";
import type { Point } from "./types";
import { add, dot, scaled, subtract } from "./vectors";

export interface Ray {
  origin: Point;
  direction: Point;
}

export class Sight {
  /**
   * @param eye of the scene
   * @param width of the viewport, in pixels
   * @param height of the viewport, in pixels
   */
  constructor(
    readonly eye: Eye,
    readonly width: number,
    readonly height: number,
  ) {}

  /** The same camera where points are placed at `shift + factor * point`. */
  within(factor: number, shift: Point): Sight {
    const position = scaled(subtract(this.eye.position, shift), 1 / factor);
    return new Sight({ ...this.eye, position }, this.width, this.height);
  }

  /** Pixels of one unit at one unit ahead. */
  get focal(): number {
    return this.height / (2 * SLOPE);
  }

  /** The ray through a pixel; x from the left, y from the top. */
  ray(x: number, y: number): Ray {
    const { position, right, up, ahead } = this.eye;
    const across = (x - this.width / 2) / this.focal;
    const upward = (this.height / 2 - y) / this.focal;
    const direction = add(ahead, add(scaled(right, across), scaled(up, upward)));
    return { origin: position, direction };
  }

  /** Pixel and depth of a point; behind the eye the pixel is NaN. */
  project(point: Point): [number, number, number] {
    const { position, right, up, ahead } = this.eye;
    const seen = subtract(point, position);
    const depth = dot(seen, ahead);
    const across = depth > 0 ? this.focal / depth : NaN;
    return [
      this.width / 2 + dot(seen, right) * across,
      this.height / 2 - dot(seen, up) * across,
      depth,
    ];
  }

  /** Pixels and depth of many points (n, 3), into `(n, 3)`. */
  projectAll(positions: Float32Array, into: Float64Array): void {
    const [ex, ey, ez] = this.eye.position;
    const [rx, ry, rz] = this.eye.right;
    const [ux, uy, uz] = this.eye.up;
    const [ax, ay, az] = this.eye.ahead;
    const { focal } = this;
    const [middle, centre] = [this.width / 2, this.height / 2];
    for (let i = 0; i < positions.length; i += 3) {
      const x = positions[i]! - ex;
      const y = positions[i + 1]! - ey;
      const z = positions[i + 2]! - ez;
      const depth = x * ax + y * ay + z * az;
      const across = depth > 0 ? focal / depth : NaN;
      into[i] = middle + (x * rx + y * ry + z * rz) * across;
      into[i + 1] = centre - (x * ux + y * uy + z * uz) * across;
      into[i + 2] = depth;
    }
  }
}
