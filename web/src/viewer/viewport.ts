/** One picture: surfaces, what is put over them, and the tool in hand. */
import { PerspectiveCamera, Matrix4, Scene, Vector3, type WebGLRenderer } from "three";
import { Bounds } from "./bounds";
import { Compass } from "./compass";
import { Events } from "./events";
import { Gizmo } from "./gizmo";
import { Hand } from "./hand";
import { Legend } from "./legend";
import { Lines } from "./lines";
import { Marks } from "./marks";
import { FIELD_OF_VIEW, needed, Pose } from "./pose";
import { Sight } from "./sight";
import { SurfaceView } from "./surface";
import { hitAt } from "./targets";
import type { Look } from "./themes";
import type {
  Hit,
  Point,
  Side,
  SurfaceData,
  SurfaceStyle,
  Tool,
  View,
  ViewportEvents,
} from "./types";
import { add, alike, scaled, toLocal, toWorld, type Frame } from "./vectors";

/** Pixels beside a surface up to which a click means its nearest visible vertex. */
const SNAP = 10;

/** What a viewport asks of its stage. */
export interface Host {
  look: Look;
  /** A picture is needed; of all viewports with this pose, if given. */
  invalidate(pose?: Pose): void;
  /** Shows the surfaces of all viewports with a pose. */
  fit(pose: Pose): void;
}

export class Viewport {
  /** Over the picture; takes the mouse and holds labels. */
  readonly element = document.createElement("div");
  readonly marks: Marks;
  readonly lines: Lines;
  readonly gizmo: Gizmo;
  readonly legend: Legend;
  /** Shared by linked viewports; changed by the stage. */
  pose = new Pose();
  /** Radius of the brush, in space. */
  brushRadius = 0;
  /** CSS colour of what the brush touches until the regions are next set. */
  brushColour = "#e8892b";
  private readonly scene = new Scene();
  private readonly eye = new PerspectiveCamera(FIELD_OF_VIEW);
  private readonly surfaces = new Map<string, SurfaceView>();
  private readonly events = new Events<ViewportEvents>();
  private readonly heading = document.createElement("div");
  private readonly hand: Hand;
  private readonly compass: Compass;
  private frameOfScene: Frame | null = null;
  private reach = { centre: new Vector3(), radius: 1 };
  private stale = true;
  private size: [number, number] = [1, 1];

  constructor(
    private readonly host: Host,
    label: string,
  ) {
    this.element.className = "viewer-viewport";
    this.element.setAttribute("role", "application");
    this.element.setAttribute("aria-label", label);
    this.element.tabIndex = 0;
    this.heading.className = "viewer-title";
    this.element.append(this.heading);
    const changed = () => {
      this.stale = true;
      this.host.invalidate();
    };
    const surroundings = () => ({
      surfaces: [...this.surfaces.values()],
      sight: this.sight(),
      frame: this.frameNow,
    });
    this.lines = new Lines(surroundings, changed);
    this.marks = new Marks(this.element, surroundings, changed);
    this.legend = new Legend(this.element);
    this.compass = new Compass(this.element);
    this.eye.matrixAutoUpdate = false;
    this.gizmo = new Gizmo(this.eye, this.element, this.scene, () => this.frameNow, changed);
    this.hand = new Hand(this, this.events);
    this.scene.add(this.lines.group);
  }

  /** The coordinates of the scene: those of the first surface. */
  get frameNow(): Frame {
    return this.frameOfScene ?? { centre: [0, 0, 0], scale: 1 };
  }

  get tool(): Tool {
    return this.hand.tool;
  }

  set tool(tool: Tool) {
    this.hand.tool = tool;
  }

  /** Keys of the surfaces. */
  get keys(): string[] {
    return [...this.surfaces.keys()];
  }

  /** Adds a surface, in place of one with the same key. */
  add(key: string, data: SurfaceData, style: Partial<SurfaceStyle> = {}): SurfaceView {
    this.surfaces.get(key)?.dispose();
    const first = [...this.surfaces.keys()].every((other) => other === key);
    const changed = (shape: boolean) => {
      this.stale ||= shape;
      this.host.invalidate();
    };
    const surface = new SurfaceView(key, data, this.host.look, changed);
    this.surfaces.set(key, surface);
    this.scene.add(surface.group);
    surface.style(style);
    if (first) this.settle({ centre: [...data.centre], scale: data.scale });
    else surface.locate(this.frameNow);
    this.stale = true;
    this.host.invalidate();
    return surface;
  }

  /** Takes the frame of a first surface, unless what was there before is about the same. */
  private settle(frame: Frame): void {
    const known = this.frameOfScene;
    const keep = known !== null && alike(frame, known);
    if (!keep) this.frameOfScene = frame;
    for (const surface of this.surfaces.values()) surface.locate(this.frameNow);
    this.lines.lay();
    if (!keep) this.frame();
  }

  surface(key: string): SurfaceView | undefined {
    return this.surfaces.get(key);
  }

  remove(key: string): void {
    this.surfaces.get(key)?.dispose();
    this.surfaces.delete(key);
    this.stale = true;
    this.host.invalidate();
  }

  /** Takes away all surfaces, marks and lines, the gizmo, the legend and the title. */
  clear(): void {
    for (const key of this.keys) this.remove(key);
    this.marks.set([]);
    this.lines.set([]);
    this.gizmo.detach();
    this.legend.set(null);
    this.title("");
  }

  /** Takes the coordinates of the surface that comes next, whatever they were before. */
  settleAnew(): void {
    this.frameOfScene = null;
  }

  on<Name extends keyof ViewportEvents>(
    name: Name,
    handler: (event: ViewportEvents[Name]) => void,
  ): () => void {
    return this.events.on(name, handler);
  }

  title(text: string): void {
    this.heading.textContent = text;
  }

  /** Shows all surfaces as large as they fit, of linked viewports too. */
  frame(): void {
    this.host.fit(this.pose);
    this.turned();
  }

  /** Looks from a side; `front` looks against the z axis, or along y if z is upward. */
  view(side: Side): void {
    this.pose.look(side);
    this.turned();
  }

  /** Looks as a camera, as far as a turntable can. */
  look(view: Pick<View, "position" | "target">): void {
    const frame = this.frameNow;
    this.pose.place(toLocal(frame, view.position), toLocal(frame, view.target));
    this.turned();
  }

  /** The camera as it is, in space. */
  camera(): View {
    const { position, up } = this.pose.eye();
    const frame = this.frameNow;
    return {
      position: toWorld(frame, position),
      target: toWorld(frame, this.pose.target),
      up,
      field_of_view: FIELD_OF_VIEW,
      aspect: this.size[0] / this.size[1],
    };
  }

  /** The pose changed: linked viewports follow. */
  turned(): void {
    this.host.invalidate(this.pose);
  }

  /** Tells listeners that the camera moved. */
  tell(): void {
    this.place();
    if (this.events.has("camera")) this.events.emit("camera", this.camera());
  }

  /** Ends what the mouse is doing as if it had not been. */
  cancel(): void {
    this.hand.cancel();
  }

  /** What is at a place of the page, null for nothing. */
  pick(x: number, y: number): Hit | null {
    const { left, top } = this.element.getBoundingClientRect();
    return this.hitAt(x - left, y - top, SNAP);
  }

  /** What is at a pixel of the viewport. */
  hitAt(x: number, y: number, snap = SNAP): Hit | null {
    return hitAt(this.solids, this.sight(), x, y, snap);
  }

  private get solids(): SurfaceView[] {
    return [...this.surfaces.values()].filter((surface) => surface.solid);
  }

  /** Where a vertex is on the page, in pixels. */
  project(key: string, vertex: number): [number, number] {
    const surface = this.surfaces.get(key);
    if (!surface) throw new Error(`there is no surface ${key} in this viewport`);
    const { left, top } = this.element.getBoundingClientRect();
    const [x, y] = this.sight().project(toLocal(this.frameNow, surface.vertexAt(vertex)));
    return [x + left, y + top];
  }

  /** The camera in the coordinates of the scene, with the viewport's pixels. */
  sight(): Sight {
    return new Sight(this.pose.eye(), ...this.size);
  }

  /** The box around all visible surfaces, in the coordinates of the scene. */
  bounds(): Bounds {
    const bounds = new Bounds();
    for (const { styled, bounds: own, placed } of this.surfaces.values()) {
      if (styled.visible) bounds.join(own, placed.factor, placed.shift);
    }
    return bounds;
  }

  /** The distance from a target of the scene from which all visible surfaces are seen. */
  needed(target: Point): number {
    const eye = this.pose.eye();
    const distances = [...this.surfaces.values()].map((surface) => {
      const { factor, shift } = surface.placed;
      const own = scaled(add(target, scaled(shift, -1)), 1 / factor);
      const { positions, used, styled } = surface;
      return styled.visible ? factor * needed(positions, used, eye, own, this.aspect) : 0;
    });
    return Math.max(0, ...distances);
  }

  /** Puts the viewport at a place of the stage. */
  resize(left: number, width: number, height: number): void {
    this.size = [Math.max(1, width), Math.max(1, height)];
    Object.assign(this.element.style, {
      left: `${left}px`,
      width: `${width}px`,
      height: `${height}px`,
    });
    this.place();
  }

  get aspect(): number {
    return this.size[0] / this.size[1];
  }

  /** Brings the camera of three.js to the pose. */
  private place(): void {
    const { position, right, up, ahead } = this.pose.eye();
    const back = scaled(ahead, -1);
    this.eye.matrix.copy(
      new Matrix4().makeBasis(new Vector3(...right), new Vector3(...up), new Vector3(...back)),
    );
    this.eye.matrix.setPosition(...position);
    this.eye.matrix.decompose(this.eye.position, this.eye.quaternion, this.eye.scale);
    this.eye.updateMatrixWorld(true);
    const centre = add(position, scaled(this.reach.centre.toArray(), -1));
    const apart = Math.hypot(...centre);
    this.eye.far = apart + this.reach.radius * 1.5 + 0.1;
    this.eye.near = Math.max(apart - this.reach.radius * 1.5, this.eye.far * 2e-4);
    this.eye.aspect = this.aspect;
    this.eye.updateProjectionMatrix();
  }

  /** Draws into its part of the canvas. */
  render(renderer: WebGLRenderer, ratio: number, drawing: boolean, settle: boolean): void {
    if (this.stale) this.measure();
    this.place();
    const eye = this.pose.eye();
    const sight = this.sight();
    this.host.look.follow(eye, this.pose.upward);
    this.lines.face(eye);
    this.lines.group.visible = drawing;
    this.compass.turn(eye);
    this.gizmo.face(eye);
    const [width, height] = this.size;
    for (const surface of this.surfaces.values()) {
      surface.prepare(sight.focal, width * ratio, height * ratio, drawing);
    }
    renderer.render(this.scene, this.eye);
    if (drawing) this.marks.update(settle);
  }

  private measure(): void {
    this.stale = false;
    this.lines.follow();
    const bounds = this.bounds();
    bounds.join(this.lines.bounds, 1, [0, 0, 0]);
    if (this.gizmo.place) bounds.add(...this.gizmo.place);
    if (bounds.empty) return;
    this.reach.centre.set(...bounds.centre);
    this.reach.radius = bounds.radius;
  }

  /** Surfaces take the colours of the theme. */
  redress(): void {
    for (const surface of this.surfaces.values()) surface.style({});
  }

  dispose(): void {
    this.clear();
    this.hand.dispose();
    this.gizmo.dispose();
    this.element.remove();
  }
}
