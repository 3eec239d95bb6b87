/** Glides a surface from where it is seen to where it was sent, so that it deforms and does not jump. */

import type { SurfaceView } from "../../viewer/index.ts";

const milliseconds = 350;
const still = matchMedia("(prefers-reduced-motion: reduce)");

const ease = (t: number) => t * t * (3 - 2 * t);

export class Gliding {
  private surface: SurfaceView | null = null;
  private from: Float32Array | null = null;
  private to: Float32Array | null = null;
  private start = 0;
  private frame = 0;

  /** The surface has new positions, and glides there from where it was seen last; true if these are
   * its first. */
  take(surface: SurfaceView): boolean {
    const to = surface.positions.slice();
    if (surface !== this.surface || !this.to || still.matches) {
      const first = surface !== this.surface;
      this.stop();
      [this.surface, this.from, this.to] = [surface, to, to];
      return first;
    }
    this.from = this.seen();
    this.to = to;
    this.start = performance.now();
    this.draw();
    this.frame ||= requestAnimationFrame(() => this.step());
    return false;
  }

  stop(): void {
    cancelAnimationFrame(this.frame);
    this.frame = 0;
    this.surface = this.from = this.to = null;
  }

  /** How far it has come, from 0 to 1. */
  private get share(): number {
    return ease(Math.min((performance.now() - this.start) / milliseconds, 1));
  }

  private seen(): Float32Array {
    const [from, to, t] = [this.from!, this.to!, this.share];
    return from.map((value, i) => value + t * (to[i]! - value));
  }

  private draw(): void {
    this.surface!.morph(this.from!, this.to!, this.share);
  }

  private step(): void {
    this.frame = 0;
    if (!this.surface) return;
    this.draw();
    if (this.share < 1) this.frame = requestAnimationFrame(() => this.step());
  }
}
