import { Connection, type Listener, type Status } from "../connection.ts";
import { Data } from "../data.ts";
import type { Arrays, Message } from "../messages.ts";
import type {
  BasisHeader,
  Ended,
  FrameHeader,
  Job,
  MeshEntry,
  Packed,
  State,
  TabName,
} from "../state.ts";
import { stats } from "../stats.ts";
import { tabNamed, tabs } from "../tabs/index.ts";
import type { AnyTab, Look, Studio, Tool } from "../tabs/tab.ts";
import type { Level, Toast } from "../ui/index.ts";
import type { Stage } from "../viewer/index.ts";
import { Awaited, requestExport } from "./downloads.ts";
import { keep, kept } from "./kept.ts";
import { Moved } from "./moved.ts";
import { Scenes } from "./scenes.ts";
import { chooseTheme, followTheme, theme } from "./theme.ts";
import { type Upload, upload } from "./uploads.ts";

/** What lies above the page. */
export type Overlay = "start" | "help" | null;

const mostToasts = 3;
const isRecipe = (file: File) => file.name.toLowerCase().endsWith(".json");

/**
 * The page: what it knows, and what can be done. What is drawn follows from it: `subscribe` tells
 * whenever it changed.
 */
export class App implements Studio, Listener {
  readonly blobs = new Data();
  readonly moved = new Moved(this.blobs);
  readonly scenes: Scenes;
  readonly connection: Connection;
  state: State | null = null;
  status: Status = "connecting";
  tab: AnyTab = tabs[0]!;
  tool: Tool = this.tab.tools[0]!;
  look: Look = {
    edges: true,
    creases: true,
    shading: "smooth",
    ...kept<Partial<Look>>("look", {}),
  };
  upward: "y" | "z" = kept("upward", "y");
  overlay: Overlay = null;
  toasts: Toast[] = [];
  uploads: Upload[] = [];
  jobs: Job[] = [];
  hinted: string | null = null;
  /** Actions that were not answered yet. */
  working = 0;
  /** Tabs that the server was told of, and did not answer yet: what it says is of another one. */
  private opening = 0;
  private listeners = new Set<() => void>();
  private told = false;
  private toastCount = 0;
  private readonly exports = new Awaited();
  private followingTheme: () => void;

  constructor(
    readonly stage: Stage,
    /** The element that the stage is in. */
    readonly place: HTMLElement,
  ) {
    this.scenes = new Scenes(this);
    stage.upward(this.upward);
    this.followingTheme = followTheme((next) => this.stage.theme(next));
    this.connection = new Connection(this, kept("slow", false) ? 16 : 32);
  }

  /** Whether the line is slow: positions then have 16 bits while something is dragged. */
  get slow(): boolean {
    return this.connection.precision === 16;
  }

  set slow(slow: boolean) {
    keep("slow", slow);
    this.connection.precision = slow ? 16 : 32;
    this.redraw();
  }

  get viewports() {
    return this.stage.viewports;
  }

  /** Whether no mesh is open; then the page says how to begin. */
  get isEmpty(): boolean {
    return (this.state?.meshes.length ?? 0) === 0;
  }

  /** Tells of changes, of several at once only once. */
  subscribe(listener: () => void): () => void {
    this.listeners.add(listener);
    return () => void this.listeners.delete(listener);
  }

  redraw(): void {
    if (this.told) return;
    this.told = true;
    queueMicrotask(() => {
      this.told = false;
      for (const listener of this.listeners) listener();
    });
  }

  changed(): void {
    this.redraw();
    this.scenes.bring();
  }

  // What the server says

  onStatus(status: Status): void {
    this.status = status;
    if (status === "connected") {
      this.moved.clear();
      this.jobs = [];
    }
    this.redraw();
  }

  onState(state: State): void {
    this.state = state;
    for (const job of state.jobs) this.noteJob(job);
    for (const ended of state.exported) if (this.exports.note(ended)) this.tellFailure(ended);
    document.title = [...state.meshes.map((mesh) => mesh.name), "henkei studio"].join(" – ");
    if (this.opening === 0 && state.tab !== this.tab.name) this.bringForward(state.tab);
    this.changed();
  }

  onFrame(message: Message<FrameHeader>): void {
    this.moved.take(message, this.scenes.shown === message.header.tab ? this.viewports : []);
    if (this.scenes.shown === message.header.tab) this.tab.frame?.(message, this);
  }

  whenDrawn(done: () => void): void {
    this.stage.whenDrawn(done);
  }

  onBasis(message: Message<BasisHeader>): void {
    if (this.scenes.shown === message.header.tab) this.tab.basis?.(message, this);
  }

  onProgress(job: Job): void {
    const begins = this.jobs.every((one) => one.job !== job.job);
    this.noteJob(job);
    if (begins) this.changed();
    else this.redraw();
  }

  private noteJob(job: Job): void {
    const known = this.jobs.some((one) => one.job === job.job);
    this.jobs = known
      ? this.jobs.map((one) => (one.job === job.job ? { ...one, ...job } : one))
      : [...this.jobs, job];
  }

  onEnded(ended: Ended): void {
    this.jobs = this.jobs.filter((one) => one.job !== ended.job);
    if (ended.file) this.exports.note(ended);
    this.tellFailure(ended);
    this.changed();
  }

  private tellFailure({ outcome, message }: Ended): void {
    if (outcome !== "done" && outcome !== "cancelled" && message) this.notify("error", message);
  }

  onNotice(level: Level, message: string): void {
    this.notify(level, message);
  }

  // What people do

  async do(tab: TabName | "document", action: string, args: object = {}, arrays: Arrays = {}) {
    return this.answered(this.connection.do(tab, action, args, arrays));
  }

  live(tab: TabName, action: string, args: object = {}, arrays: Arrays = {}): void {
    this.connection.live(tab, action, args, arrays);
  }

  drop(): void {
    this.connection.drop();
  }

  grab(tab: TabName, args: object = {}): void {
    this.connection.send("grab", { tab, arguments: args });
  }

  async undo(): Promise<void> {
    await this.answered(this.connection.ask("undo"), "info");
  }

  async redo(): Promise<void> {
    await this.answered(this.connection.ask("redo"), "info");
  }

  cancel(job: string): void {
    this.connection.send("cancel", { job });
  }

  /** An example, or an earlier session: the server opens its tab. */
  async begin(action: "example" | "restore" | "new", args: object = {}): Promise<void> {
    if (await this.do("document", action, args)) this.show(null);
  }

  private async answered(
    outcome: ReturnType<Connection["ask"]>,
    refused: Level = "error",
  ): Promise<boolean> {
    this.working += 1;
    this.redraw();
    const answer = await outcome;
    this.working -= 1;
    if (!answer.done) this.notify(refused, answer.message);
    this.redraw();
    return answer.done;
  }

  /** Opens a tab. The server is told, as it prepares only what the tab in front shows. */
  async open(name: TabName): Promise<void> {
    if (name === this.tab.name) return;
    this.bringForward(name);
    this.opening += 1;
    await this.do("document", "show", { name });
    this.opening -= 1;
  }

  private bringForward(name: TabName): void {
    const tab = tabNamed(name);
    if (!tab) return;
    this.tab = tab;
    this.tool = tab.tools[0]!;
    this.hinted = null;
    this.changed();
  }

  take(name: string): void {
    const tool = this.tab.tools.find((one) => one.name === name);
    if (!tool) return;
    this.tool = tool;
    this.hinted = null;
    for (const viewport of this.viewports) viewport.tool = tool.viewport;
    this.tab.tool?.(this, tool);
    this.redraw();
  }

  /** The first tool, or what else Escape goes back to. */
  escape(): void {
    if (this.overlay) this.show(null);
    else if (this.tab.escape?.(this)) return;
    else if (this.tool !== this.tab.tools[0]) this.take(this.tab.tools[0]!.name);
    else this.dismiss(this.toasts.at(-1)?.id);
  }

  show(overlay: Overlay): void {
    this.overlay = overlay;
    this.redraw();
  }

  hint(text: string | null): void {
    if (text === this.hinted) return;
    this.hinted = text;
    this.redraw();
  }

  switchEdges(): void {
    this.setLook({ edges: !this.look.edges, creases: !this.look.edges });
  }

  /** Chooses the axis of space that is upward on the screen. */
  turnUpward(axis: "y" | "z"): void {
    this.upward = axis;
    keep("upward", axis);
    this.stage.upward(axis);
    this.frame();
    this.redraw();
  }

  setLook(look: Partial<Look>): void {
    this.look = { ...this.look, ...look };
    keep("look", this.look);
    this.changed();
  }

  switchTheme(): void {
    chooseTheme(theme() === "dark" ? "light" : "dark");
    this.followingTheme();
    this.redraw();
  }

  frame(): void {
    for (const viewport of this.viewports) viewport.frame();
  }

  notify(level: Level, text: string, more: Pick<Toast, "action" | "ofFile"> = {}): void {
    const again = this.toasts.find((toast) => toast.text === text && toast.level === level);
    if (again) {
      this.toasts = this.toasts.map((one) =>
        one === again ? { ...one, times: one.times + 1 } : one,
      );
    } else {
      const toast = { id: ++this.toastCount, level, text, times: 1, ...more };
      this.toasts = [...this.toasts, toast].slice(-mostToasts);
    }
    this.redraw();
  }

  dismiss(toast: number | undefined): void {
    this.toasts = this.toasts.filter((one) => one.id !== toast);
    this.redraw();
  }

  /** Something in the page itself went wrong: it goes on, and people are told. */
  failed(error: unknown): void {
    const text = error instanceof Error ? error.message : String(error);
    stats.errors.push(error instanceof Error ? (error.stack ?? text) : text);
    console.error(error);
    this.notify(
      "error",
      `Something went wrong in the page: ${text}. Your work is kept by the server. If something looks wrong now, load the page again.`,
      { action: { label: "Load again", run: () => location.reload() } },
    );
  }

  // What is open

  data(id: string): Promise<Message> {
    return this.blobs.get(id);
  }

  surface(id: string) {
    return this.blobs.surface(id);
  }

  async numbers(list: Packed): Promise<ArrayLike<number>> {
    return Array.isArray(list) ? list.flat() : (await this.data(list.blob)).arrays.values!;
  }

  mesh(id: string | null): MeshEntry | undefined {
    return this.state?.meshes.find((one) => one.id === id);
  }

  async upload(files: Iterable<File>): Promise<string[]> {
    const given = [...files];
    this.toasts = this.toasts.filter((one) => !one.ofFile);
    const left = (await this.tab.receive?.(this, given)) ?? given;
    const [recipes, others] = [true, false].map((are) =>
      left.filter((one) => isRecipe(one) === are),
    );
    const meshes: string[] = [];
    // one by one: meshes are open in the files' order, and before recipes that are for them
    for (const file of [...others!, ...recipes!]) {
      const mesh = await this.uploadOne(file);
      if (mesh !== null) meshes.push(mesh);
    }
    if (meshes.length > 0) {
      if (this.overlay === "start") this.show(null);
    }
    return meshes;
  }

  private async uploadOne(file: File): Promise<string | null> {
    const { upload: sent, answer } = upload(file, () => this.redraw());
    this.uploads = [...this.uploads, sent];
    this.redraw();
    const { mesh, message } = await answer;
    this.uploads = this.uploads.filter((one) => one !== sent);
    if (message) this.notify("error", message, { ofFile: true });
    this.redraw();
    return mesh ?? null;
  }

  async exportAs(tab: TabName, format: string, options: object = {}): Promise<void> {
    const asked = await requestExport({ tab, format, options });
    if (asked.file) this.exports.add(asked.file);
    else if (asked.message) this.notify("error", asked.message);
  }
}
