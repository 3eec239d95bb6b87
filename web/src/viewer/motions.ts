/** Positions (n, 3) made from others, without a byte from the server. */
import type { Point } from "./types";

/** (1 - t) a + t b, into `positions`. */
export function morphed(
  a: Float32Array,
  b: Float32Array,
  t: number,
  positions: Float32Array,
): void {
  const rest = 1 - t;
  for (let i = 0; i < positions.length; i++) positions[i] = rest * a[i]! + t * b[i]!;
}

/**
 * start + response * translation, into `positions`.
 *
 * @param response (n,) a share for each vertex; (n, 3) one for each axis; or (3, n, 3) where a unit
 *   along each axis takes it
 */
export function blended(
  start: Float32Array,
  response: Float32Array,
  translation: Point,
  positions: Float32Array,
): void {
  const size = positions.length;
  if (response.length === size / 3) byShare(start, response, translation, positions);
  else if (response.length === size) byAxis(start, response, translation, positions);
  else if (response.length === 3 * size) byWay(start, response, translation, positions);
  else throw new Error(`a response to ${size / 3} vertices cannot have ${response.length} values`);
}

function byShare(start: Float32Array, response: Float32Array, by: Point, to: Float32Array): void {
  const [x, y, z] = by;
  for (let vertex = 0, i = 0; vertex < response.length; vertex++, i += 3) {
    const share = response[vertex]!;
    to[i] = start[i]! + share * x;
    to[i + 1] = start[i + 1]! + share * y;
    to[i + 2] = start[i + 2]! + share * z;
  }
}

function byAxis(start: Float32Array, response: Float32Array, by: Point, to: Float32Array): void {
  const [x, y, z] = by;
  for (let i = 0; i < to.length; i += 3) {
    to[i] = start[i]! + response[i]! * x;
    to[i + 1] = start[i + 1]! + response[i + 1]! * y;
    to[i + 2] = start[i + 2]! + response[i + 2]! * z;
  }
}

function byWay(start: Float32Array, response: Float32Array, by: Point, to: Float32Array): void {
  const [x, y, z] = by;
  const size = to.length;
  for (let i = 0; i < size; i++) {
    const along = response[i]! * x + response[size + i]! * y + response[2 * size + i]! * z;
    to[i] = start[i]! + along;
  }
}
