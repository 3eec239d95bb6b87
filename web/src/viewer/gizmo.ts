/** Arrows and rings to move and turn something with. */
import { Object3D, Quaternion, Vector3, type PerspectiveCamera, type Scene } from "three";
import { TransformControls } from "three/addons/controls/TransformControls.js";
import type { Eye } from "./pose";
import { EDGE_ON, Turning } from "./turning";
import type { Point } from "./types";
import { add, scaled, toLocal, type Frame } from "./vectors";

export type GizmoMode = "translate" | "rotate";

/** A pose against the place of attachment. */
export interface GizmoPose {
  /** In space. */
  translation: Point;
  /** Rotation vector: along the axis, as long as the angle in radians. */
  rotation: Point;
}

export interface GizmoTarget {
  /** Where the thing is at rest, in space. */
  position: Point;
  /** How far it is moved already. */
  translation?: Point;
  /** How far it is turned already, as a rotation vector. */
  rotation?: Point;
  modes?: readonly GizmoMode[];
}

export interface GizmoHandlers {
  onStart?(): void;
  onChange?(pose: GizmoPose): void;
  onEnd?(pose: GizmoPose): void;
}

const SIZES: Record<GizmoMode, number> = { translate: 0.85, rotate: 1.1 };

const COLOURS = ["#d9485a", "#4f9d4b", "#3f7fd6", "#f0a93b"] as const;

export class Gizmo {
  private readonly handle = new Object3D();
  private readonly controls = new Map<GizmoMode, TransformControls>();
  private handlers: GizmoHandlers = {};
  private rest: Point = [0, 0, 0];
  private attached = false;
  private readonly turning: Turning;

  constructor(
    private readonly camera: PerspectiveCamera,
    private readonly element: HTMLElement,
    private readonly scene: Scene,
    private readonly frame: () => Frame,
    private readonly changed: () => void,
  ) {
    this.turning = new Turning(camera, element);
  }

  /** Where it is in the scene, null for nowhere. */
  get place(): Point | null {
    const { x, y, z } = this.handle.position;
    return this.attached ? [x, y, z] : null;
  }

  /** Shows the rings that an eye does not see from their side. */
  face({ ahead }: Eye): void {
    const rings = this.controls.get("rotate");
    if (!rings || rings.dragging) return;
    rings.showX = Math.abs(ahead[0]) > EDGE_ON;
    rings.showY = Math.abs(ahead[1]) > EDGE_ON;
    rings.showZ = Math.abs(ahead[2]) > EDGE_ON;
  }

  /** Whether the pointer is over it, or drags it. */
  get busy(): boolean {
    return (
      this.attached && [...this.controls.values()].some(({ axis, dragging }) => axis || dragging)
    );
  }

  /** Shows it at a thing; a drag tells the thing's pose. */
  attach(target: GizmoTarget, handlers: GizmoHandlers = {}): void {
    const modes = target.modes ?? ["translate"];
    this.handlers = handlers;
    this.rest = target.position;
    this.attached = true;
    this.scene.add(this.handle);
    if (!this.dragging) this.put(target.translation ?? [0, 0, 0], target.rotation ?? [0, 0, 0]);
    for (const mode of ["translate", "rotate"] as const) {
      if (modes.includes(mode)) this.show(mode);
      else this.hide(mode);
    }
    this.changed();
  }

  detach(): void {
    this.attached = false;
    this.handlers = {};
    this.hide("translate");
    this.hide("rotate");
    this.handle.removeFromParent();
    this.changed();
  }

  private get dragging(): boolean {
    return [...this.controls.values()].some((controls) => controls.dragging);
  }

  private put(translation: Point, rotation: Point): void {
    this.handle.position.set(...toLocal(this.frame(), add(this.rest, translation)));
    const angle = Math.hypot(...rotation);
    const axis = new Vector3(...scaled(rotation, angle > 0 ? 1 / angle : 0));
    this.handle.quaternion.setFromAxisAngle(axis, angle);
  }

  private show(mode: GizmoMode): void {
    const controls = this.controls.get(mode) ?? this.made(mode);
    controls.enabled = true;
    controls.attach(this.handle);
    this.scene.add(controls.getHelper());
  }

  private hide(mode: GizmoMode): void {
    const controls = this.controls.get(mode);
    if (!controls) return;
    controls.detach();
    controls.axis = null;
    controls.enabled = false;
    controls.getHelper().removeFromParent();
  }

  private made(mode: GizmoMode): TransformControls {
    const controls = new TransformControls(this.camera, this.element);
    controls.setMode(mode);
    controls.setSize(SIZES[mode]);
    controls.setColors(...COLOURS);
    controls.showE = controls.showXYZE = false;
    controls.addEventListener("change", () => this.changed());
    controls.addEventListener("mouseDown", () => {
      if (mode === "rotate" && controls.axis) this.turning.begin(this.handle, controls.axis);
      this.handlers.onStart?.();
    });
    controls.addEventListener("objectChange", () => {
      if (mode === "rotate" && controls.axis) this.turning.turn(this.handle, controls.axis);
      this.handlers.onChange?.(this.pose());
    });
    controls.addEventListener("mouseUp", () => this.handlers.onEnd?.(this.pose()));
    controls.addEventListener("axis-changed", () => this.yield());
    this.controls.set(mode, controls);
    return controls;
  }

  /** Lets the arrows have the pointer where a ring is under them too. */
  private yield(): void {
    const [arrows, rings] = [this.controls.get("translate"), this.controls.get("rotate")];
    if (!arrows?.object || !rings?.object || rings.dragging) return;
    rings.enabled = arrows.axis === null;
    if (arrows.axis !== null) rings.axis = null;
  }

  private pose(): GizmoPose {
    const { scale } = this.frame();
    const from = toLocal(this.frame(), this.rest);
    const { x, y, z } = this.handle.position;
    const translation = scaled(add([x, y, z], scaled(from, -1)), scale);
    return { translation, rotation: rotationVector(this.handle.quaternion) };
  }

  dispose(): void {
    this.detach();
    this.turning.dispose();
    for (const controls of this.controls.values()) controls.dispose();
  }
}

/** Along the axis, as long as the angle; at most half a turn. */
function rotationVector(quaternion: Quaternion): Point {
  const sign = quaternion.w < 0 ? -1 : 1;
  const [x, y, z] = [quaternion.x * sign, quaternion.y * sign, quaternion.z * sign];
  const sine = Math.hypot(x, y, z);
  if (sine === 0) return [0, 0, 0];
  return scaled([x, y, z], (2 * Math.atan2(sine, quaternion.w * sign)) / sine);
}
