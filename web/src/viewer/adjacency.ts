/** The triangles around each vertex. */

export class Adjacency {
  /** (n + 1,) where each vertex's triangles start. */
  readonly start: Uint32Array;
  /** (3 t,) of the first vertex, of the second, and so on. */
  readonly triangles: Uint32Array;
  private readonly stamps: Uint32Array;
  private stamp = 0;

  constructor(
    private readonly corners: Uint32Array,
    count: number,
  ) {
    this.start = new Uint32Array(count + 1);
    this.triangles = new Uint32Array(corners.length);
    this.stamps = new Uint32Array(count);
    for (const vertex of corners) this.start[vertex + 1]! += 1;
    for (let i = 0; i < count; i++) this.start[i + 1]! += this.start[i]!;
    const next = this.start.slice(0, count);
    for (let i = 0; i < corners.length; i++) {
      this.triangles[next[corners[i]!]!++] = Math.floor(i / 3);
    }
  }

  /** The vertices of all triangles around some vertices, and those themselves. */
  around(vertices: ArrayLike<number>): Uint32Array {
    const { stamps, corners } = this;
    const stamp = ++this.stamp;
    const found: number[] = [];
    const take = (vertex: number) => {
      if (stamps[vertex] === stamp) return;
      stamps[vertex] = stamp;
      found.push(vertex);
    };
    for (let i = 0; i < vertices.length; i++) {
      const vertex = vertices[i]!;
      take(vertex);
      for (let k = this.start[vertex]!; k < this.start[vertex + 1]!; k++) {
        const first = 3 * this.triangles[k]!;
        take(corners[first]!);
        take(corners[first + 1]!);
        take(corners[first + 2]!);
      }
    }
    return Uint32Array.from(found);
  }

  /** Vertices reached from the corners of a triangle over edges between those `accepted`. */
  connected(triangle: number, accepted: (vertex: number) => boolean): number[] {
    const { stamps, corners } = this;
    const stamp = ++this.stamp;
    const found: number[] = [];
    const visit = (first: number) => {
      for (let i = first; i < first + 3; i++) {
        const vertex = corners[i]!;
        if (stamps[vertex] === stamp) continue;
        stamps[vertex] = stamp;
        if (accepted(vertex)) found.push(vertex);
      }
    };
    visit(3 * triangle);
    for (let next = 0; next < found.length; next++) {
      const vertex = found[next]!;
      for (let k = this.start[vertex]!; k < this.start[vertex + 1]!; k++) {
        visit(3 * this.triangles[k]!);
      }
    }
    return found;
  }
}
