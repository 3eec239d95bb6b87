import { address, credentials } from "./address.ts";
import { decode, type Message } from "./messages.ts";
import type { FrameHeader } from "./state.ts";
import type { SurfaceData } from "./viewer/index.ts";

/** The blob that a surface is from, and its counts. */
export type Source = { id: string; vertices: number; faces: number };

const mostBytes = 768 << 20;

/** Blobs of the server. They never change, so what was fetched is kept; the least used goes first. */
export class Data {
  private kept = new Map<string, { message: Promise<Message>; bytes: number }>();
  private bytes = 0;
  private surfaces = new Map<string, WeakRef<SurfaceData>>();
  private sources = new WeakMap<SurfaceData, Source>();

  get(id: string): Promise<Message> {
    const known = this.kept.get(id);
    if (known) {
      this.kept.delete(id); // and in again, as the last one used
      this.kept.set(id, known);
      return known.message;
    }
    const entry = { message: this.fetched(id), bytes: 0 };
    this.kept.set(id, entry);
    entry.message.catch(() => this.kept.delete(id));
    return entry.message;
  }

  /**
   * A surface, as the viewer takes it: the same object while it is in use. Its arrays are shared,
   * and not to be changed.
   */
  async surface(id: string): Promise<SurfaceData> {
    const { header, arrays } = await this.get(id);
    const known = this.surfaces.get(id)?.deref();
    if (known) return known;
    const surface: SurfaceData = {
      positions: arrays.positions as Float32Array,
      triangles: arrays.triangles as Uint32Array,
      edges: arrays.edges as Uint32Array,
      creases: arrays.creases as Uint32Array | undefined,
      face: arrays.face as Uint32Array | undefined,
      centre: header.centre as SurfaceData["centre"],
      scale: header.scale as number,
    };
    const { vertices, faces } = header as { vertices: number; faces: number };
    this.surfaces.set(id, new WeakRef(surface));
    this.sources.set(surface, { id, vertices, faces });
    return surface;
  }

  /** What a surface was made of; undefined if it is not from here. */
  source(surface: SurfaceData): Source | undefined {
    return this.sources.get(surface);
  }

  private async fetched(id: string): Promise<Message> {
    const bytes = await this.bytesOf(id);
    const entry = this.kept.get(id);
    if (entry) entry.bytes = bytes.byteLength;
    this.bytes += bytes.byteLength;
    for (const [oldest, { bytes: size }] of this.kept) {
      if (this.bytes <= mostBytes) break;
      if (oldest === id || size === 0) continue; // it is on its way
      this.kept.delete(oldest);
      this.bytes -= size;
    }
    return decode(bytes);
  }

  /** Tried again while the server does not answer: it may be on its way back. */
  private async bytesOf(id: string): Promise<ArrayBuffer> {
    for (let wait = 200; ; wait = Math.min(2 * wait, 3000)) {
      let response: Response;
      try {
        response = await fetch(address(`data/${id}`), { headers: credentials() });
        if (response.ok) return await response.arrayBuffer();
      } catch {
        await new Promise((resolve) => setTimeout(resolve, wait));
        continue;
      }
      throw new Error(`the server does not have data ${id} (${response.status})`);
    }
  }
}

/** The positions in a frame (three each), as the surface's data has them: normalised. */
export function positionsOf(message: Message<FrameHeader>): {
  ids: Uint32Array | null;
  positions: Float32Array;
} {
  const { positions, ids = null } = message.arrays;
  if (positions instanceof Float32Array) return { ids: ids as Uint32Array | null, positions };
  const { low = [0, 0, 0], high = [0, 0, 0] } = message.header;
  const whole = 65535;
  const unpacked = new Float32Array(positions!.length);
  for (let axis = 0; axis < 3; axis++) {
    const first = low[axis]!;
    const factor = (high[axis]! - first) / whole;
    for (let k = axis; k < unpacked.length; k += 3) unpacked[k] = first + factor * positions![k]!;
  }
  return { ids: ids as Uint32Array | null, positions: unpacked };
}
