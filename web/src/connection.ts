import { address, credentials, remember, remembered, socketAddress } from "./address.ts";
import { type Arrays, decode, encode, type Header, type Message } from "./messages.ts";
import type { BasisHeader, Ended, FrameHeader, Job, State, TabEntry, TabName } from "./state.ts";
import { noteLatency, stats } from "./stats.ts";
import type { Level } from "./ui/section.tsx";

export type Status =
  /** not yet answered */
  | "connecting"
  | "connected"
  /** was there, and is not now */
  | "away"
  /** is there, and lets this page not in */
  | "locked";

/** What the server answered to something that it was asked to do. */
export type Outcome = { done: true } | { done: false; message: string };

/** Who hears what the server says. */
export interface Listener {
  onStatus(status: Status): void;
  onState(state: State): void;
  onFrame(message: Message<FrameHeader>): void;
  /** Calls back when the positions are with the graphics card: then the frame is acknowledged. */
  whenDrawn(done: () => void): void;
  onBasis(message: Message<BasisHeader>): void;
  onProgress(job: Job): void;
  onEnded(ended: Ended): void;
  onNotice(level: Level, message: string): void;
}

type Waiting = { bytes: ArrayBuffer; settle(outcome: Outcome): void };
type Live = { sequence: number; header: Header; arrays: Arrays };

const shortestWait = 200; // milliseconds until it is tried again
const longestWait = 3000;
const liveGap = 4; // milliseconds between live actions: more of them in that time are one
const mostBuffered = 1 << 18; // bytes not yet sent, from which on live actions wait

/**
 * The web socket to the server, for ever: when it is lost it is opened again, and what was not
 * answered is asked again.
 */
export class Connection {
  status: Status = "connecting";
  private socket: WebSocket | null = null;
  private session = remembered("session");
  private waiting = new Map<string, Waiting>();
  private readonly page = Math.random().toString(36).slice(2, 10);
  private asked = 0;
  private sequence = 0;
  private nextLive: Live | null = null;
  private lastLive = 0;
  private liveTimer = 0;
  private askedAt = new Map<number, number>();
  private wait = shortestWait;
  private timer = 0;
  private tabs: Partial<Record<TabName, TabEntry>> = {};

  constructor(
    private readonly listener: Listener,
    private bits: 32 | 16 = 32,
  ) {
    for (const event of ["online", "pageshow"]) addEventListener(event, () => this.hurry());
    document.addEventListener("visibilitychange", () => this.hurry());
    this.open();
  }

  /** Asks for something that is answered by `done` or `refused`; also while the server is away. */
  ask(kind: string, header: Header = {}, arrays: Arrays = {}): Promise<Outcome> {
    const id = `${this.page}-${++this.asked}`;
    const bytes = encode({ ...header, kind, id }, arrays);
    return new Promise((settle) => {
      this.waiting.set(id, { bytes, settle });
      if (this.status === "connected") this.socket!.send(bytes);
    });
  }

  /** Does an action and commits it; it takes the place of a live one that was not sent yet. */
  do(tab: TabName | "document", action: string, args: object = {}, arrays: Arrays = {}) {
    this.nextLive = null;
    return this.ask("do", { tab, action, arguments: args }, arrays);
  }

  /**
   * Tries an action while it is being dragged. Of what comes faster than it can be sent the latest
   * wins. It does not wait for the screen's next picture, which would cost half of it on average,
   * and far more where pictures take long.
   */
  live(tab: TabName, action: string, args: object = {}, arrays: Arrays = {}): number {
    const sequence = ++this.sequence;
    stats.live.asked += 1;
    this.askedAt.set(sequence, performance.now());
    this.nextLive = { sequence, header: { tab, action, arguments: args }, arrays };
    this.flushLive();
    return sequence;
  }

  /** Sends something that is not answered; nothing while the server is away. */
  send(kind: string, header: Header = {}, arrays: Arrays = {}): void {
    if (this.status === "connected") this.socket!.send(encode({ ...header, kind }, arrays));
  }

  /** Ends a drag without committing it; where the server is away, when it is back. */
  drop(): void {
    this.nextLive = null;
    void this.ask("drop");
  }

  private flushLive(): void {
    clearTimeout(this.liveTimer);
    if (!this.nextLive || this.status !== "connected") return;
    const left = this.lastLive + liveGap - performance.now();
    if (left > 0 || this.socket!.bufferedAmount > mostBuffered) {
      this.liveTimer = setTimeout(() => this.flushLive(), Math.max(left, 1));
      return;
    }
    const { sequence, header, arrays } = this.nextLive;
    this.nextLive = null;
    this.lastLive = performance.now();
    stats.live.sent += 1;
    this.send("live", { ...header, sequence }, arrays);
  }

  /** Of coordinates while something is dragged: 16 halve what a slow line has to carry. */
  get precision(): 32 | 16 {
    return this.bits;
  }

  set precision(bits: 32 | 16) {
    this.bits = bits;
    if (this.status === "connected") this.greet(this.socket!);
  }

  private greet(socket: WebSocket): void {
    this.tabs = {};
    const { session, bits, page } = this;
    socket.send(encode({ kind: "hello", session, bits, page }));
  }

  private open(): void {
    clearTimeout(this.timer);
    const socket = new WebSocket(socketAddress());
    socket.binaryType = "arraybuffer";
    this.socket = socket;
    socket.onopen = () => {
      stats.connections += 1;
      this.wait = shortestWait;
      this.greet(socket);
      this.become("connected");
      for (const { bytes } of this.waiting.values()) socket.send(bytes);
      this.flushLive();
    };
    socket.onmessage = ({ data }) => this.receive(data as ArrayBuffer);
    socket.onclose = () => {
      if (socket === this.socket) void this.lost();
    };
  }

  private async lost(): Promise<void> {
    this.socket = null;
    this.askedAt.clear();
    if (this.status === "connected") this.become("away");
    this.timer = setTimeout(() => this.open(), this.wait);
    this.wait = Math.min(1.6 * this.wait, longestWait);
    const refused = await isRefused();
    if (this.status !== "connected") this.become(refused ? "locked" : "away");
  }

  /** Tries at once what would be tried later. */
  private hurry(): void {
    if (this.socket || document.hidden) return;
    this.wait = shortestWait;
    this.open();
  }

  private become(status: Status): void {
    if (status === this.status) return;
    this.status = status;
    this.listener.onStatus(status);
  }

  private receive(bytes: ArrayBuffer): void {
    const message = decode(bytes);
    const header = message.header;
    stats.received.messages += 1;
    stats.received.bytes += bytes.byteLength;
    switch (header.kind) {
      case "state":
        return this.receiveState(header);
      case "frame":
        return this.receiveFrame(message as unknown as Message<FrameHeader>);
      case "basis":
        return this.listener.onBasis(message as unknown as Message<BasisHeader>);
      case "done":
        return this.settle(header.id as string, { done: true });
      case "refused":
        return this.settle(header.id as string, { done: false, message: String(header.message) });
      case "progress":
        return this.listener.onProgress(header as unknown as Job);
      case "ended":
        return this.listener.onEnded(header as unknown as Ended);
      case "notice":
        return this.listener.onNotice((header.level as Level) ?? "info", String(header.message));
      default:
        throw new Error(`the server sent a message of unknown kind ${String(header.kind)}`);
    }
  }

  private receiveState(header: Header): void {
    stats.received.states += 1;
    this.tabs = { ...this.tabs, ...(header.tabs as State["tabs"]) };
    const state = { ...header, tabs: this.tabs } as unknown as State;
    this.session = state.session;
    remember("session", state.session);
    this.listener.onState(state);
  }

  private receiveFrame(message: Message<FrameHeader>): void {
    const { number, sequence } = message.header;
    try {
      this.listener.onFrame(message);
    } finally {
      this.listener.whenDrawn(() => this.send("ack", { number }));
    }
    stats.received.frames += 1;
    if (sequence == null) return;
    const asked = this.askedAt.get(sequence);
    if (asked !== undefined) noteLatency(sequence, performance.now() - asked);
    for (const earlier of this.askedAt.keys())
      if (earlier <= sequence) this.askedAt.delete(earlier);
  }

  private settle(id: string | undefined, outcome: Outcome): void {
    const waiting = id === undefined ? undefined : this.waiting.get(id);
    if (waiting) {
      this.waiting.delete(id!);
      waiting.settle(outcome);
    } else if (!outcome.done) this.listener.onNotice("error", outcome.message);
  }
}

/** Whether the server is there, but does not accept this page's token: a web socket cannot tell. */
async function isRefused(): Promise<boolean> {
  try {
    const nothing = address(`data/${"0".repeat(32)}`);
    return (await fetch(nothing, { headers: credentials(), cache: "no-store" })).status === 403;
  } catch {
    return false;
  }
}
