/** Surfaces in the browser: drawn, coloured, picked and painted. */
export type { Colours } from "./paint";
export type { SurfaceView } from "./surface";
export { category, gradient, type Colormap } from "./colormaps";
export type { GizmoHandlers, GizmoMode, GizmoPose, GizmoTarget } from "./gizmo";
export type { LegendContent } from "./legend";
export type { PolyLine } from "./lines";
export type { Mark } from "./marks";
export { Stage, type Stats } from "./stage";
export type * from "./types";
export type { Viewport } from "./viewport";
