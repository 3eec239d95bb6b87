import { type Data, positionsOf } from "../data.ts";
import type { Message } from "../messages.ts";
import type { FrameHeader, TabName } from "../state.ts";
import type { SurfaceView, Viewport } from "../viewer/index.ts";

type Held = { data: string | undefined; positions: Float32Array; drawn: SurfaceView | null };

/**
 * Where the surfaces that move are now. A frame has only what moved since the one before, and may
 * come while its surface is not drawn: because its data is on the way, or another tab is open.
 */
export class Moved {
  private held = new Map<string, Held>();

  constructor(private readonly data: Data) {}

  /** Takes a frame, and moves the surface if it is drawn. */
  take(message: Message<FrameHeader>, viewports: readonly Viewport[]): void {
    const { tab, surface, data, exact } = message.header;
    const { ids, positions } = positionsOf(message);
    const key = `${tab} ${surface}`;
    const before = this.held.get(key);
    if (ids && before) {
      merge(before.positions, ids, positions);
    } else if (!ids) this.held.set(key, { data, positions, drawn: before?.drawn ?? null });
    const held = this.held.get(key);
    const view = held && this.drawn(surface, held, viewports);
    if (!view) return;
    // at rest a surface has all it should, whatever the page itself did to it meanwhile
    if (ids && !exact && held.drawn === view) view.move(ids, positions);
    else view.setPositions(held.positions);
    held.drawn = view;
  }

  /** Moves what was drawn anew in a tab to where it is. */
  catchUp(tab: TabName, viewports: readonly Viewport[]): void {
    for (const [key, held] of this.held) {
      if (!key.startsWith(`${tab} `)) continue;
      const view = this.drawn(key.slice(tab.length + 1), held, viewports);
      if (!view || view === held.drawn) continue;
      view.setPositions(held.positions);
      held.drawn = view;
    }
  }

  /** What was said before the server was lost counts no more. */
  clear(): void {
    this.held.clear();
  }

  private drawn(surface: string, held: Held, viewports: readonly Viewport[]): SurfaceView | null {
    for (const viewport of viewports) {
      const view = viewport.surface(surface);
      if (!view) continue;
      const same = held.data === undefined || this.data.source(view.data)?.id === held.data;
      return same && view.data.positions.length === held.positions.length ? view : null;
    }
    return null;
  }
}

/** Puts positions (k, 3) in place of those of the vertices `ids` (k,). */
function merge(all: Float32Array, ids: Uint32Array, positions: Float32Array): void {
  for (let k = 0, from = 0; k < ids.length; k++) {
    const to = 3 * ids[k]!;
    all[to] = positions[from++]!;
    all[to + 1] = positions[from++]!;
    all[to + 2] = positions[from++]!;
  }
}
