/** Figures of the connection, for tests and for measuring. */
export const stats = {
  connections: 0,
  received: { messages: 0, bytes: 0, states: 0, frames: 0 },
  /** Of live actions: how many were asked for, and how many were sent. */
  live: { asked: 0, sent: 0 },
  /** [sequence, milliseconds from asking for a live action until its frame was in the buffers]. */
  latencies: [] as [number, number][],
  /** Errors of the page itself. */
  errors: [] as string[],
};

const most = 20_000;

export function noteLatency(sequence: number, milliseconds: number): void {
  if (stats.latencies.length >= most) stats.latencies.splice(0, most / 2);
  stats.latencies.push([sequence, milliseconds]);
}
