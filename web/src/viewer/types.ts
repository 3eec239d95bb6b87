/** What goes into the viewer and what comes out of it. */

/** Three numbers: a point or a direction. */
export type Point = [number, number, number];

/** A surface as the server sends it; in space, a vertex is at `centre + scale * position`. */
export interface SurfaceData {
  /** (n, 3), normalised so that surfaces far from the origin keep their digits. */
  positions: Float32Array;
  /** (t, 3) vertices. */
  triangles: Uint32Array;
  /** (e, 2) edges of the polygons, without the diagonals. */
  edges: Uint32Array;
  /** (c, 2) sharp and boundary edges. */
  creases?: Uint32Array;
  /** (t,) polygon of each triangle; without it, every triangle is a face. */
  face?: Uint32Array;
  centre: Point;
  scale: number;
}

/** A camera in space, as recipes keep it. */
export interface View {
  position: Point;
  target: Point;
  up: Point;
  /** Degrees from the bottom to the top of the picture. */
  field_of_view: number;
  /** Width by height. */
  aspect: number;
}

/** Keys held during an event; `ctrl` is also the command key. */
export interface Modifiers {
  shift: boolean;
  alt: boolean;
  ctrl: boolean;
}

/** A place on a surface under the pointer. */
export interface Hit {
  /** Key of the surface. */
  surface: string;
  /** The corner of the face that is nearest to the pointer on the screen. */
  vertex: number;
  /** The polygon hit. */
  face: number;
  triangle: number;
  /** Weights of the triangle's corners. */
  barycentric: Point;
  /** In space. */
  point: Point;
  /** True if the pointer is beside the surface, and `vertex` the nearest one that can be seen. */
  snapped: boolean;
}

export interface PickEvent extends Hit, Modifiers {
  /** Id of the visible mark under the pointer. */
  mark: string | null;
}

export interface OutlineEvent extends Modifiers {
  /** Corners [x, y]; the viewport's middle is [0, 0], its upper right corner [1, 1]. */
  polygon: [number, number][];
  camera: View;
}

export interface StrokeEvent extends Modifiers {
  surface: string;
  /** All vertices touched since the pointer went down, sorted. */
  ids: Uint32Array;
  done: boolean;
}

/** Events of a viewport by name. */
export interface ViewportEvents {
  pick: PickEvent;
  /** What a click would pick now; null beside the surfaces. */
  hover: Hit | null;
  outline: OutlineEvent;
  stroke: StrokeEvent;
  /** A click that met no surface. */
  miss: Modifiers;
  /** The camera moved. */
  camera: View;
}

export type Tool = "orbit" | "pick" | "rectangle" | "lasso" | "brush";

export type Side = "front" | "back" | "left" | "right" | "top" | "bottom";

export type Theme = "light" | "dark";

/** A point in space, or one that stays on a vertex of a surface of the viewport. */
export type Anchor = readonly number[] | { surface: string; vertex: number };

/** Groups of vertices to tint; where two meet, the later one is seen. */
export interface Region {
  ids: ArrayLike<number>;
  /** CSS colour. */
  colour: string;
}

export interface SurfaceStyle {
  visible: boolean;
  shading: "smooth" | "flat";
  edges: boolean;
  creases: boolean;
  /** From 0 to 1. */
  opacity: number;
  /** CSS colour; null is the theme's. */
  colour: string | null;
  /** CSS colour of its edges, which then hardly fade where they crowd; null is the theme's. */
  lineColour: string | null;
  /** CSS colour of its creases, which then do not fade; null is the theme's. */
  creaseColour: string | null;
  /** Whether its faces are drawn, or only its edges and creases. */
  faces: boolean;
  /** Whether pointers meet the surface, and marks hide behind it. */
  solid: boolean;
}
