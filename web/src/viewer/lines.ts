/** Lines some pixels wide; faint dashes where they are behind a surface. */
import { Color, GreaterDepth, Group, LessEqualDepth, type DepthModes } from "three";
import { Line2 } from "three/addons/lines/Line2.js";
import { LineGeometry } from "three/addons/lines/LineGeometry.js";
import { LineMaterial } from "three/addons/lines/LineMaterial.js";
import { Bounds } from "./bounds";
import type { Eye } from "./pose";
import type { SurfaceView } from "./surface";
import { anchored } from "./targets";
import type { Anchor } from "./types";
import { scaled, type Frame } from "./vectors";

export interface PolyLine {
  id: string;
  /** CSS colour. */
  colour: string;
  points: readonly Anchor[];
  closed?: boolean;
  /** Pixels. */
  width?: number;
}

/** Lines are drawn this much nearer to the eye, so that the surface they lie on is behind them. */
const NEARER = 0.996;

/** Before surfaces, and dashed behind them. */
const PASSES: { depthFunc: DepthModes; opacity: number; dashed: boolean; order: number }[] = [
  { depthFunc: LessEqualDepth, opacity: 1, dashed: false, order: 31 },
  { depthFunc: GreaterDepth, opacity: 0.4, dashed: true, order: 30 },
];

/** In the scene's unit. */
const DASH = { dashSize: 0.02, gapSize: 0.012 };

export class Lines {
  readonly group = new Group();
  /** In the coordinates of the scene. */
  bounds = new Bounds();
  private lines: PolyLine[] = [];

  constructor(
    private readonly around: () => { surfaces: readonly SurfaceView[]; frame: Frame },
    private readonly changed: () => void,
  ) {
    this.group.matrixAutoUpdate = false;
  }

  /** Shows these lines and no others. */
  set(lines: readonly PolyLine[]): void {
    this.lines = [...lines];
    this.lay();
    this.changed();
  }

  /** Brings lines on surfaces to where those are now. */
  follow(): void {
    const bound = ({ points }: PolyLine) => points.some((point) => "surface" in point);
    if (this.lines.some(bound)) this.lay();
  }

  /** Lays all lines anew. */
  lay(): void {
    this.clear();
    this.bounds = new Bounds();
    const { surfaces, frame } = this.around();
    for (const line of this.lines) {
      const found = line.points.map((point) => anchored(point, surfaces, frame));
      const points = found.filter((point) => point !== null);
      for (const point of points) this.bounds.add(...point);
      if (line.closed && points.length > 2) points.push(points[0]!);
      if (points.length > 1) this.draw(line, points.flat());
    }
  }

  private draw(line: PolyLine, coordinates: number[]): void {
    const geometry = new LineGeometry();
    geometry.setPositions(coordinates);
    for (const { depthFunc, opacity, dashed, order } of PASSES) {
      const material = new LineMaterial({
        linewidth: line.width ?? 3,
        transparent: true,
        opacity,
        depthFunc,
        dashed,
        ...DASH,
        depthWrite: false,
      });
      material.color = new Color(line.colour);
      const drawn = new Line2(geometry, material);
      drawn.computeLineDistances();
      drawn.frustumCulled = false;
      drawn.renderOrder = order;
      this.group.add(drawn);
    }
  }

  /** Draws them as seen by an eye. */
  face(eye: Eye): void {
    this.group.matrix
      .makeScale(NEARER, NEARER, NEARER)
      .setPosition(...scaled(eye.position, 1 - NEARER));
    this.group.matrixWorldNeedsUpdate = true;
  }

  private clear(): void {
    for (const line of this.group.children as Line2[]) {
      line.geometry.dispose();
      line.material.dispose();
    }
    this.group.clear();
  }

  dispose(): void {
    this.clear();
    this.group.removeFromParent();
  }
}
