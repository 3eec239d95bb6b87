/**
 * Vertices of two surfaces that correspond: clicked in turn, shown as numbered marks, and dragged
 * along to other vertices.
 */

import type { Mark, Viewport } from "../../viewer/index.ts";
import type { Studio } from "../tab.ts";
import { nearestSeen } from "./snapping.ts";

/** Of the two viewports, in their order. */
export type Side = 0 | 1;

/** Pairs of one kind. */
export interface Group {
  kind: string;
  /** Vertices of both surfaces. */
  pairs: readonly (readonly [number, number])[];
  /** What a pair is called on its marks. */
  label(index: number): string;
  /** Where one end is in space, if that is not its vertex. */
  at?(index: number, side: Side): readonly number[] | null;
  /** The only vertices of each surface that these may be, if not all. */
  places?: readonly [ArrayLike<number>, ArrayLike<number>];
}

export interface PairingHandlers {
  /** Both vertices of a new pair were clicked. */
  add(kind: string, pair: [number, number]): Promise<unknown>;
  /** A mark was dragged to another vertex. */
  move(kind: string, index: number, side: Side, vertex: number): Promise<unknown>;
  /** What is pending, selected or dragged has changed. */
  changed(): void;
}

interface Place {
  kind: string;
  side: Side;
  vertex: number;
}

/** A mark that is dragged. */
interface Dragged extends Place {
  index: number;
  moved: boolean;
}

/** Pixels from which on a press is a drag. */
const steady = 4;

/** Pixels beside the surface up to which a click means one of its possible places. */
const beside = 40;

/** CSS colour of the pair of a number: neighbours in the list are well apart. */
export const pairColour = (index: number) =>
  `hsl(${Math.round((index * 137.508 + 205) % 360)} 72% ${index % 2 ? 46 : 52}%)`;

export class Pairing {
  /** The kind that clicks add; null: clicks add nothing. */
  kind: string | null = null;
  /** Whether marks are shown and clicks are heard. */
  active = true;
  /** The half of a pair that was clicked. */
  pending: Place | null = null;
  /** Id of a pair, as {@link idOf} makes it. */
  selected: string | null = null;
  private dragged: Dragged | null = null;
  private hovered: Place | null = null;
  private groups: readonly Group[] = [];
  private at: [number, number] = [0, 0];
  private studio: Studio | null = null;

  /** @param keys of the surfaces in the two viewports */
  constructor(
    private readonly keys: readonly [string, string],
    private readonly handlers: PairingHandlers,
  ) {}

  static idOf(kind: string, index: number): string {
    return `${kind} ${index}`;
  }

  /** Listens to the two viewports of the stage; what it returns ends that. */
  enter(studio: Studio): (() => void)[] {
    this.studio = studio;
    this.reset();
    return studio.viewports.slice(0, 2).flatMap((viewport, k) => {
      const side = k as Side;
      const ended = new AbortController();
      const options = { signal: ended.signal, capture: true };
      viewport.element.addEventListener("pointermove", (event) => this.track(event), options);
      viewport.element.addEventListener("pointerdown", (e) => this.press(e, side), options);
      return [
        viewport.on("pick", (hit) => this.click(side, hit.surface, hit.vertex)),
        viewport.on("miss", () => this.click(side, null, null)),
        viewport.on("hover", (hit) => this.hover(side, hit?.surface ?? null, hit?.vertex ?? null)),
        () => ended.abort(),
      ];
    });
  }

  /** Forgets what is half done. */
  reset(): void {
    this.pending = this.dragged = this.hovered = this.selected = null;
  }

  /** Leaves what is half done; false if nothing was. */
  escape(): boolean {
    const used = this.pending !== null || this.selected !== null;
    this.pending = this.selected = null;
    if (used) this.handlers.changed();
    return used;
  }

  /** Clicks add pairs of another kind now. */
  take(kind: string | null): void {
    this.kind = kind;
    this.pending = this.hovered = null;
  }

  select(id: string | null): void {
    this.selected = id;
    this.handlers.changed();
  }

  /** Kind and index of the selected pair. */
  get chosen(): { kind: string; index: number } | null {
    return this.selected === null ? null : parsed(this.selected);
  }

  /** Shows the marks of these pairs. */
  show(groups: readonly Group[]): void {
    this.groups = groups;
    const chosen = this.chosen;
    if (chosen && chosen.index >= (this.group(chosen.kind)?.pairs.length ?? 0)) {
      this.selected = null;
    }
    this.mark();
  }

  private group(kind: string): Group | undefined {
    return this.groups.find((one) => one.kind === kind);
  }

  private viewport(side: Side): Viewport {
    return this.studio!.viewports[side]!;
  }

  private mark(): void {
    if (!this.active) return;
    for (const side of [0, 1] as const) this.viewport(side)?.marks.set(this.marks(side));
  }

  private marks(side: Side): Mark[] {
    const surface = this.keys[side];
    const marks: Mark[] = this.groups.flatMap(({ kind, pairs, label, at }) =>
      pairs.map((pair, index) => {
        const id = Pairing.idOf(kind, index);
        const { dragged } = this;
        const held = dragged?.kind === kind && dragged.index === index && dragged.side === side;
        return {
          id,
          label: kind === this.kind || id === this.selected ? label(index) : undefined,
          colour: pairColour(index),
          position: (!held && at?.(index, side)) || {
            surface,
            vertex: held ? dragged.vertex : pair[side],
          },
          selected: held || id === this.selected,
        };
      }),
    );
    for (const [id, place] of [
      ["pending", this.pending],
      ["hovered", this.dragged ? null : this.hovered],
    ] as const) {
      if (place?.side !== side) continue;
      const group = this.group(place.kind);
      const index = group?.pairs.length ?? 0;
      marks.push({
        id,
        label: id === "pending" ? group?.label(index) : undefined,
        colour: pairColour(index),
        position: { surface, vertex: place.vertex },
        selected: id === "pending",
      });
    }
    return marks;
  }

  /** The vertex that is meant at the pointer, of those that a kind may be at. */
  private meant(side: Side, kind: string, surface: string | null, vertex: number | null) {
    const places = this.group(kind)?.places?.[side];
    if (!places) return surface === this.keys[side] ? vertex : null;
    const reach = surface === null ? beside : Infinity;
    return nearestSeen(this.viewport(side), this.keys[side], places, ...this.at, reach);
  }

  private click(side: Side, surface: string | null, vertex: number | null): void {
    const { kind } = this;
    if (!this.active || kind === null) return;
    const meant = this.meant(side, kind, surface, vertex);
    if (meant === null) return;
    this.hovered = null;
    const { pending } = this;
    if (pending === null || pending.side === side) {
      this.pending = { kind, side, vertex: meant };
    } else {
      this.pending = null;
      const pair: [number, number] = side === 1 ? [pending.vertex, meant] : [meant, pending.vertex];
      void this.handlers.add(kind, pair);
    }
    this.selected = null;
    this.handlers.changed();
  }

  private hover(side: Side, surface: string | null, vertex: number | null): void {
    if (!this.active || this.dragged) return;
    const { kind } = this;
    const over = this.markAt(side) !== null;
    this.viewport(side).element.style.cursor = over && kind !== null ? "move" : "";
    const limited = kind !== null && this.group(kind)?.places !== undefined;
    const meant = limited && !over && surface ? this.meant(side, kind, surface, vertex) : null;
    const before = this.hovered?.side === side ? this.hovered.vertex : null;
    if (meant === before) return;
    this.hovered = meant === null ? null : { kind: kind!, side, vertex: meant };
    this.mark();
  }

  /** The pair whose mark is under the pointer. */
  private markAt(side: Side): { kind: string; index: number } | null {
    const viewport = this.viewport(side);
    const { left, top } = viewport.element.getBoundingClientRect();
    const found = parsed(viewport.marks.at(this.at[0] - left, this.at[1] - top) ?? "");
    return found && this.group(found.kind)?.pairs[found.index] ? found : null;
  }

  // Dragging a mark

  private track(event: PointerEvent): void {
    this.at = [event.clientX, event.clientY];
  }

  private press(event: PointerEvent, side: Side): void {
    this.track(event);
    if (!this.active || this.kind === null || event.button !== 0 || event.altKey) return;
    const found = this.markAt(side);
    const pair = found && this.group(found.kind)!.pairs[found.index]!;
    if (!pair) return;
    event.stopImmediatePropagation();
    this.hold(this.viewport(side), event, { ...found, side, vertex: pair[side], moved: false });
  }

  private hold(viewport: Viewport, begun: PointerEvent, dragged: Dragged): void {
    const { element } = viewport;
    const start = dragged.vertex;
    const ended = new AbortController();
    const options = { signal: ended.signal, capture: true };
    element.focus({ preventScroll: true });
    element.setPointerCapture(begun.pointerId);
    this.dragged = dragged;
    this.selected = Pairing.idOf(dragged.kind, dragged.index);
    const move = (event: PointerEvent) => {
      event.stopImmediatePropagation();
      this.track(event);
      const away = Math.hypot(event.clientX - begun.clientX, event.clientY - begun.clientY);
      dragged.moved ||= away >= steady;
      if (!dragged.moved) return;
      const hit = viewport.pick(event.clientX, event.clientY);
      const { side, kind } = dragged;
      dragged.vertex =
        this.meant(side, kind, hit?.surface ?? null, hit?.vertex ?? null) ?? dragged.vertex;
      this.mark();
    };
    const end = (kept: boolean) => {
      ended.abort();
      if (kept && dragged.vertex !== start) {
        const { kind, index, side, vertex } = dragged;
        // the mark stays where it was dropped until the server has answered
        void this.handlers.move(kind, index, side, vertex).finally(() => this.release(dragged));
      } else this.release(dragged);
    };
    element.addEventListener("pointermove", move, options);
    element.addEventListener(
      "pointerup",
      (event) => {
        event.stopImmediatePropagation();
        end(true);
      },
      options,
    );
    element.addEventListener("pointercancel", () => end(false), options);
    addEventListener("keydown", (event) => event.key === "Escape" && end(false), options);
    this.handlers.changed();
  }

  private release(dragged: Dragged): void {
    if (this.dragged === dragged) this.dragged = null;
    this.handlers.changed();
  }
}

function parsed(id: string): { kind: string; index: number } | null {
  const [kind, index] = id.split(" ");
  return index === undefined ? null : { kind: kind!, index: Number(index) };
}
