/** Arrays of a surface's vertices that change, and what is sent of them to the graphics card. */
import { BufferAttribute, DynamicDrawUsage } from "three";

/** Vertices sent together. */
const CHUNK = 2048;

/** Values of all vertices, sent whole or in the parts that changed. */
export class VertexArray<Values extends Float32Array | Uint8Array = Float32Array> {
  readonly attribute: BufferAttribute;
  private whole = false;

  /**
   * @param values (n, size); the last ones are those of the copies
   * @param copies (c,) vertex of which each of the last c is a copy
   */
  constructor(
    readonly values: Values,
    readonly size: number,
    private readonly copies: Uint32Array,
    normalized = false,
  ) {
    this.attribute = new BufferAttribute(values, size, normalized).setUsage(DynamicDrawUsage);
    this.attribute.onUpload(() => (this.whole = false));
  }

  /** All values changed. */
  changed(): void {
    this.copy();
    this.attribute.clearUpdateRanges();
    this.attribute.needsUpdate = true;
    this.whole = true;
  }

  /** The values of some vertices changed. */
  changedAt(vertices: ArrayLike<number>): void {
    this.copy();
    this.attribute.needsUpdate = true;
    if (this.whole) return;
    const chunks = new Uint8Array(Math.ceil(this.attribute.count / CHUNK));
    for (let i = 0; i < vertices.length; i++) chunks[Math.floor(vertices[i]! / CHUNK)] = 1;
    const first = this.attribute.count - this.copies.length;
    if (this.copies.length > 0) chunks.fill(1, Math.floor(first / CHUNK));
    for (let from = 0; from < chunks.length; from++) {
      let to = from;
      while (chunks[to]) to += 1;
      if (to > from) this.send(from, to);
      from = to;
    }
  }

  private send(from: number, to: number): void {
    const first = from * CHUNK * this.size;
    const last = Math.min(to * CHUNK * this.size, this.values.length);
    this.attribute.addUpdateRange(first, last - first);
  }

  private copy(): void {
    const { values, size, copies } = this;
    let to = values.length - size * copies.length;
    for (const vertex of copies) {
      for (let k = 0; k < size; k++) values[to++] = values[vertex * size + k]!;
    }
  }
}

/** How each face gets a vertex of its own, whose colour it takes (its triangles' last corner). */
export interface Provoking {
  /** (t, 3) entries; the first n are the vertices, copies follow. */
  corners: Uint32Array;
  /** (c,) vertex of which each entry after the first n is a copy. */
  copies: Uint32Array;
  /** (n + c,) face that takes its colour from an entry, -1 for none. */
  face: Int32Array;
}

/**
 * Finds each face a vertex of its own, or makes a copy of one where all are taken.
 *
 * About as many entries as there are faces or vertices, whichever are more; three for each triangle
 * would be twice to six times that.
 */
export function provoking(
  triangles: Uint32Array,
  face: Uint32Array | undefined,
  count: number,
): Provoking {
  const corners = new Uint32Array(triangles.length);
  const owner = new Int32Array(count + triangles.length / 3).fill(-1);
  const copies: number[] = [];
  for (let i = 0; i < triangles.length; i += 3) {
    const mine = face ? face[i / 3]! : i / 3;
    const owned = cornerOf(triangles, i, owner, mine);
    const last = owned >= 0 ? owned : Math.max(0, cornerOf(triangles, i, owner, -1));
    corners[i] = triangles[i + ((last + 1) % 3)]!;
    corners[i + 1] = triangles[i + ((last + 2) % 3)]!;
    let entry = triangles[i + last]!;
    if (owner[entry] !== mine && owner[entry] !== -1) {
      copies.push(entry);
      entry = count + copies.length - 1;
    }
    owner[entry] = mine;
    corners[i + 2] = entry;
  }
  return {
    corners,
    copies: Uint32Array.from(copies),
    face: owner.slice(0, count + copies.length),
  };
}

/** Which corner of a triangle belongs to `wanted`, -1 for none. */
function cornerOf(
  triangles: Uint32Array,
  first: number,
  owner: Int32Array,
  wanted: number,
): number {
  for (let k = 0; k < 3; k++) if (owner[triangles[first + k]!] === wanted) return k;
  return -1;
}
