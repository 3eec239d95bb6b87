/** A surface in a viewport: its positions as they are now, its colours and its style. */
import type { Group } from "three";
import { Adjacency } from "./adjacency";
import { Bounds } from "./bounds";
import { VertexArray } from "./buffers";
import { Drawn } from "./drawn";
import { blended, morphed } from "./motions";
import { allNormals, someNormals } from "./normals";
import { Paint, type Colours } from "./paint";
import type { Look } from "./themes";
import type { Point, Region, SurfaceData, SurfaceStyle } from "./types";
import { between, pointAt, toWorld, type Frame } from "./vectors";

/** Of all vertices, from which on moving some costs as much as moving all. */
const MANY = 0.25;

const STYLE: SurfaceStyle = {
  visible: true,
  shading: "smooth",
  edges: true,
  creases: true,
  opacity: 1,
  colour: null,
  lineColour: null,
  creaseColour: null,
  faces: true,
  solid: true,
};

export class SurfaceView {
  /** Vertices. */
  readonly count: number;
  /** (n,) whether a triangle has the vertex. */
  readonly used: Uint8Array;
  /** Of its vertices as they are now, in the coordinates of `data`. */
  bounds: Bounds;
  /** From `data` into the viewport's scene: `shift + factor * position`. */
  placed: { factor: number; shift: Point } = { factor: 1, shift: [0, 0, 0] };
  private readonly drawn: Drawn;
  private shown: SurfaceStyle = { ...STYLE };
  private readonly paint: Paint;
  private isSplit = false;
  private place!: VertexArray;
  private normals!: VertexArray;
  private around: Adjacency | null = null;

  /**
   * @param key of the surface in its viewport
   * @param data as it came; never changed
   * @param look shared by all surfaces of the stage
   * @param changed called when it is to be drawn anew; true if its shape changed
   */
  constructor(
    readonly key: string,
    readonly data: SurfaceData,
    look: Look,
    private readonly changed: (shape: boolean) => void,
  ) {
    this.count = data.positions.length / 3;
    this.used = new Uint8Array(this.count);
    for (const vertex of data.triangles) this.used[vertex] = 1;
    this.drawn = new Drawn(look, data.edges, data.creases ?? new Uint32Array(0));
    this.paint = new Paint(data, this.drawn, look);
    this.allot(data.positions, data.triangles, new Uint32Array(0));
    this.bounds = Bounds.around(this.positions, this.used);
    this.drawn.style(this.shown);
  }

  get group(): Group {
    return this.drawn.group;
  }

  /** (n, 3), as they are now; to change them, call a method. */
  get positions(): Float32Array {
    return this.place.values.subarray(0, 3 * this.count);
  }

  get styled(): Readonly<SurfaceStyle> {
    return this.shown;
  }

  /** Whether pointers meet it. */
  get solid(): boolean {
    return this.shown.visible && this.shown.solid;
  }

  /** The triangles around each vertex, made when first asked for. */
  get adjacency(): Adjacency {
    return (this.around ??= new Adjacency(this.data.triangles, this.count));
  }

  /** Where a vertex is in space. */
  vertexAt(vertex: number): Point {
    return toWorld(this.data, pointAt(this.place.values, vertex));
  }

  /** A vertex's normal, not of unit length. */
  normalAt(vertex: number): Point {
    return pointAt(this.normals.values, vertex);
  }

  /** Moves all vertices to positions (n, 3). */
  setPositions(positions: Float32Array): void {
    this.place.values.set(positions.subarray(0, 3 * this.count));
    this.moved();
  }

  /** Moves vertices `ids` (k,) to positions (k, 3), or all (ids null) to positions (n, 3). */
  move(ids: Uint32Array | null, positions: Float32Array): void {
    if (!ids) return this.setPositions(positions);
    const place = this.place.values;
    for (let i = 0; i < ids.length; i++) {
      const to = 3 * ids[i]!;
      place[to] = positions[3 * i]!;
      place[to + 1] = positions[3 * i + 1]!;
      place[to + 2] = positions[3 * i + 2]!;
    }
    if (ids.length > MANY * this.count) this.moved();
    else this.movedSome(ids);
  }

  /**
   * Moves all vertices to start + response * translation.
   *
   * @param start (n, 3)
   * @param response (n,) the share each vertex takes of it; (n, 3) by axis; or (3, n, 3) the way it
   *   goes for each axis
   * @param translation in space
   */
  blend(start: Float32Array, response: Float32Array, translation: ArrayLike<number>): void {
    const by = [0, 1, 2].map((k) => translation[k]! / this.data.scale) as Point;
    blended(start, response, by, this.positions);
    this.moved();
  }

  /** Moves all vertices to (1 - t) a + t b. */
  morph(a: Float32Array, b: Float32Array, t: number): void {
    morphed(a, b, t, this.positions);
    this.moved();
  }

  private moved(): void {
    allNormals(this.place.values, this.data.triangles, this.normals.values);
    this.place.changed();
    this.normals.changed();
    this.bounds = Bounds.around(this.positions, this.used);
    this.changed(true);
  }

  private movedSome(ids: Uint32Array): void {
    const { values } = this.place;
    const touched = this.adjacency.around(ids);
    someNormals(values, this.data.triangles, this.adjacency, touched, this.normals.values);
    this.place.changedAt(ids);
    this.normals.changedAt(touched);
    for (const id of ids) {
      if (this.used[id]) this.bounds.add(values[3 * id]!, values[3 * id + 1]!, values[3 * id + 2]!);
    }
    this.changed(true);
  }

  /** Colours it, until told otherwise; null for its own colour. */
  colours(colours: Colours | null): void {
    this.split(colours?.per === "face");
    this.paint.apply(colours);
    this.changed(false);
  }

  /** Gives each face a vertex of its own, or takes that back. */
  private split(split: boolean): void {
    if (split === this.isSplit) return;
    this.isSplit = split;
    const { corners, copies } = split
      ? this.paint.faces
      : { corners: this.data.triangles, copies: new Uint32Array(0) };
    this.allot(this.positions, corners, copies);
  }

  /** Tints groups of vertices; an empty list takes all tints away. */
  regions(regions: readonly Region[]): void {
    this.paint.tintRegions(regions);
    this.changed(false);
  }

  /** Tints vertices over the regions, until those are next set. */
  highlight(region: Region | null): void {
    this.paint.tintStroke(region);
    this.changed(false);
  }

  /** Draws only so many creases, the first ones; until told otherwise all. */
  creasesUpTo(count: number): void {
    this.drawn.creasesUpTo(count);
    this.changed(false);
  }

  style(style: Partial<SurfaceStyle>): void {
    const before = this.solid;
    this.shown = { ...this.shown, ...style };
    this.drawn.style(this.shown);
    this.changed(before !== this.solid);
  }

  /** Puts it where a viewport's scene has its frame. */
  locate(scene: Frame): void {
    this.placed = between(this.data, scene);
    const { factor, shift } = this.placed;
    this.group.matrix.makeScale(factor, factor, factor).setPosition(...shift);
    this.group.matrixWorldNeedsUpdate = true;
  }

  /**
   * Makes ready for a picture.
   *
   * @param focal pixels of one unit of the scene, one unit ahead
   * @param width of the viewport, in pixels of the canvas
   * @param height of the viewport, in pixels of the canvas
   */
  prepare(focal: number, width: number, height: number, drawing: boolean): void {
    this.drawn.size(focal * this.placed.factor, width, height);
    this.drawn.draw(drawing);
  }

  dispose(): void {
    this.drawn.dispose();
  }

  /** Makes the arrays of all vertices, and of copies of some. */
  private allot(positions: Float32Array, corners: Uint32Array, copies: Uint32Array): void {
    const entries = this.count + copies.length;
    const place = new Float32Array(3 * entries);
    place.set(positions);
    this.place = new VertexArray(place, 3, copies);
    this.normals = new VertexArray(new Float32Array(3 * entries), 3, copies);
    allNormals(place, this.data.triangles, this.normals.values);
    this.place.changed();
    this.normals.changed();
    this.drawn.share(this.place.attribute, this.normals.attribute, corners);
    this.paint.allot(copies);
  }
}
