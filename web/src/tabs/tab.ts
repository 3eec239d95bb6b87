/** What a tab of the page is, and what it can ask of the page around it. */

import type { FunctionComponent } from "preact";
import type { Connection } from "../connection.ts";
import type { Arrays, Message } from "../messages.ts";
import type {
  BasisHeader,
  FrameHeader,
  Job,
  MeshEntry,
  Packed,
  State,
  TabName,
  View,
} from "../state.ts";
import type { IconName, Level } from "../ui/index.ts";
import type { Stage, SurfaceData, Viewport } from "../viewer/index.ts";

/** Something held in the hand: what clicks and drags on the surfaces mean. */
export interface Tool {
  name: string;
  title: string;
  icon: IconName;
  /** Its shortcut. */
  keys?: string;
  /** What every viewport's tool becomes. */
  viewport: Viewport["tool"];
  /** Shown in the status line while it is in hand: what to do with it. */
  hint: string;
}

export interface Shortcut {
  keys: string;
  /** For the list of all shortcuts. */
  does: string;
  run(studio: Studio): void;
}

/** How surfaces are drawn, as people chose it for all of them. */
export interface Look {
  edges: boolean;
  creases: boolean;
  shading: "smooth" | "flat";
}

/** A tab. `S` is its state as the server's recipe has it, `V` its view. */
export interface Tab<S = unknown, V extends View = View> {
  name: TabName;
  title: string;
  /** What it is for, in a sentence: shown on the start page. */
  about: string;
  viewports: 1 | 2;
  /** The first is in hand when the tab is opened. */
  tools: readonly Tool[];
  shortcuts: readonly Shortcut[];
  Panel: FunctionComponent<{ state: S; view: V; studio: Studio }>;
  /**
   * Brings the viewports to the state. Called after every state and every `studio.changed()`, never
   * twice at a time, and may be called when nothing changed.
   */
  scene(studio: Studio, state: S, view: V): void | Promise<void>;
  /**
   * The tab is opened: its viewports are empty, and in place. What it returns is called when the tab
   * is left (the results of `viewport.on`).
   */
  enter?(studio: Studio): readonly (() => void)[];
  leave?(studio: Studio): void;
  /** Positions came, and the surface of that key has them: for what else follows them. */
  frame?(message: Message<FrameHeader>, studio: Studio): void;
  basis?(message: Message<BasisHeader>, studio: Studio): void;
  /** A mesh was chosen on the shelf, to be worked on here. */
  use?(studio: Studio, mesh: string): void;
  /** Files were dropped, or chosen: takes those that are its own, and leaves the others. */
  receive?(studio: Studio, files: readonly File[]): Promise<readonly File[]>;
  /** A tool was taken in hand. */
  tool?(studio: Studio, tool: Tool): void;
  /** Escape was pressed, and there was nothing above the page to close: true if it was used. */
  escape?(studio: Studio): boolean;
}

/** Any tab, for lists of them. */
export type AnyTab = Tab<any, any>;

/** What the page offers its tabs. */
export interface Studio {
  readonly connection: Connection;
  readonly stage: Stage;
  readonly viewports: readonly Viewport[];
  /** The latest from the server; null before the first. */
  readonly state: State | null;
  readonly tab: AnyTab;
  readonly tool: Tool;
  readonly look: Look;
  /** Long work that goes on. */
  readonly jobs: readonly Job[];

  /** Does an action. True when it is done; false when it was refused, which people were told. */
  do(tab: TabName | "document", action: string, args?: object, arrays?: Arrays): Promise<boolean>;
  /** The same while it is being dragged: the latest wins, and nothing is committed. */
  live(tab: TabName, action: string, args?: object, arrays?: Arrays): void;
  /** Ends a drag without committing it. */
  drop(): void;
  /** A drag begins: the tab's `basis` is called if the surface answers it linearly. */
  grab(tab: TabName, args?: object): void;
  undo(): Promise<void>;
  redo(): Promise<void>;
  cancel(job: string): void;

  /** A blob, from the cache if it is there. */
  data(id: string): Promise<Message>;
  /** A blob with a surface, ready to be drawn. */
  surface(id: string): Promise<SurfaceData>;
  /** A list that may be a blob; rows one after the other. */
  numbers(list: Packed): Promise<ArrayLike<number>>;
  mesh(id: string | null): MeshEntry | undefined;

  /** A message at the corner; errors and warnings stay until they are closed. */
  notify(level: Level, text: string): void;
  /** In the status line: what to do now. null: the tool's hint. */
  hint(text: string | null): void;
  /** Something that only the page knows has changed: draw panel and scene again. */
  changed(): void;
  take(tool: string): void;
  open(tab: TabName): void;
  /** Fits all viewports to what is in them. */
  frame(): void;

  /** Opens meshes; resolves to their ids, without those that were refused. */
  upload(files: Iterable<File>): Promise<string[]>;
  exportAs(tab: TabName, format: string, options?: object): Promise<void>;
}
