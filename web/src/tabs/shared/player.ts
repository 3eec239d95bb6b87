/** The time of the morph, and its running to and fro. */
export class Player {
  /** In [0, 1]. */
  time = 0;
  /** Of one pass. */
  seconds = 2;
  private direction = 1;
  private once = false;
  private frame = 0;
  private last = 0;
  private readonly listeners = new Set<() => void>();

  get playing(): boolean {
    return this.frame !== 0;
  }

  subscribe(listener: () => void): () => void {
    this.listeners.add(listener);
    return () => void this.listeners.delete(listener);
  }

  /** Goes to a time. */
  seek(time: number): void {
    this.time = Math.min(Math.max(time, 0), 1);
    this.tell();
  }

  toggle(): void {
    if (this.playing) this.stop();
    else this.play();
  }

  /** Runs to and fro; with `once`, to the end and stays there. */
  play(once = false): void {
    if (this.playing) return;
    this.once = once;
    this.direction = this.time >= 1 ? -1 : 1;
    this.last = performance.now();
    this.frame = requestAnimationFrame((now) => this.step(now));
    this.tell();
  }

  stop(): void {
    if (!this.playing) return;
    cancelAnimationFrame(this.frame);
    this.frame = 0;
    this.tell();
  }

  private step(now: number): void {
    const passed = Math.max(0, now - this.last) / 1000 / this.seconds;
    this.last = now;
    let time = this.time + this.direction * passed;
    if (this.once && (time < 0 || time > 1)) {
      this.seek(time);
      return this.stop();
    }
    while (time < 0 || time > 1) {
      time = time < 0 ? -time : 2 - time;
      this.direction *= -1;
    }
    this.frame = requestAnimationFrame((next) => this.step(next));
    this.seek(time);
  }

  private tell(): void {
    for (const listener of this.listeners) listener();
  }
}
