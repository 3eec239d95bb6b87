/** What the server says: the types of its messages. */

export const tabNames = ["combine", "register", "deform", "quad", "design"] as const;
export type TabName = (typeof tabNames)[number];

/** An open mesh; its surface is a blob. */
export interface MeshEntry {
  id: string;
  name: string;
  surface: string;
  vertices: number;
  faces: number;
  about: string;
}

export type OptionValue = boolean | string | number[];

/** A way a tab's work can be saved as a file. */
export interface ExportFormat {
  format: string;
  label: string;
  /** A heading above it. */
  group?: string;
  /** A second line, in small. */
  detail?: string;
  /** Why it cannot be written, and what to do. */
  missing?: string;
  /** Defaults of what may be chosen, by name. */
  options?: Record<string, OptionValue>;
  /** What these options are called, and for texts, which there are. */
  choices?: { name: string; label: string; choices: string[] }[];
}

/** What every tab's view has; each tab's own has more. */
export interface View {
  /** By key: what is drawn (a blob), and whether it moves. */
  surfaces: Record<string, SurfaceEntry>;
  exports?: ExportFormat[];
  warnings?: string[];
  /** Why there is nothing else in the view. */
  problem?: string;
}

export interface SurfaceEntry {
  data: string;
  live?: boolean;
}

export interface Example {
  name: string;
  title: string;
  tab: TabName;
  about?: string;
}

/** An earlier session that can be had back. */
export interface Offer {
  session: string;
  /** When it was changed last, in seconds since 1970. */
  saved: number;
  /** Names of the meshes in it. */
  meshes: string[];
}

export interface Job {
  job: string;
  title: string;
  message?: string;
  fraction?: number | null;
  cancellable?: boolean;
  tab?: TabName;
}

export interface TabEntry {
  state: unknown;
  view: View;
}

/** All there is to know of a session. */
export interface State {
  revision: number;
  session: string;
  tab: TabName;
  meshes: MeshEntry[];
  tabs: Record<TabName, TabEntry>;
  undo: string | null;
  redo: string | null;
  jobs: Job[];
  /** How exports ended that nobody has fetched. */
  exported: Ended[];
  offers: Offer[];
  examples: Example[];
}

/** A list of numbers of a state or a view; a long one is a blob, which `studio.numbers` fetches. */
export type Packed = number[] | { blob: string };

/** Positions of a surface that moved; `ids` in the arrays says of which vertices, without it of all. */
export interface FrameHeader {
  number: number;
  tab: TabName;
  surface: string;
  /** The blob that the surface is drawn from. */
  data?: string;
  /** Of the live action that it answers. */
  sequence?: number | null;
  /** Nothing is being dragged: it is where it stays. */
  exact?: boolean;
  bits: 32 | 16;
  low?: [number, number, number];
  high?: [number, number, number];
}

/** How a surface answers a drag: positions are start + response * translation. */
export interface BasisHeader {
  tab: TabName;
  surface: string;
  /** What the page had asked with `grab`. */
  [asked: string]: unknown;
}

export interface Ended {
  job: string;
  outcome: "done" | "cancelled" | "refused" | "failed";
  message?: string;
  /** For exports: what can be fetched from `file/`, if it is done. */
  file?: string;
  name?: string;
}
