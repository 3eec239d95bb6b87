/** What three.js draws of one surface: its faces, edges and creases, over one set of positions. */
import {
  BufferAttribute,
  BufferGeometry,
  Color,
  DoubleSide,
  GLSL3,
  Group,
  LineSegments,
  Mesh,
  ShaderMaterial,
  Vector2,
  type Texture,
} from "three";
import { LINE_FRAGMENT, LINE_VERTEX, PAINT, SURFACE_FRAGMENT, SURFACE_VERTEX } from "./shaders";
import { plain, type Look } from "./themes";
import type { SurfaceStyle } from "./types";

/** Of the drawing order: opaque surfaces and their lines come before those seen through. */
const THROUGH = 10;

/** Lines fade to a share where faces are smaller than some pixels. */
const EDGES = { opacity: 0.3, share: 0, pixels: 14 };
const COLOURED = { opacity: 0.7, share: 0.4, pixels: 14 };
const CREASES = { opacity: 0.8, share: 0.3, pixels: 7 };

const uniform = <Value>(value: Value) => ({ value });

export class Drawn {
  readonly group = new Group();
  readonly faces = new BufferGeometry();
  private readonly outlines: { edges: BufferGeometry; creases: BufferGeometry };
  private readonly own = {
    colour: uniform(new Color()),
    edges: uniform(new Color()),
    creases: uniform(new Color()),
    opacity: uniform(1),
    flatness: uniform(0),
    map: uniform<Texture | null>(null),
    pixels: uniform(100),
  };
  private readonly surface: ShaderMaterial;
  private readonly depth: ShaderMaterial;
  private readonly meshes: {
    faces: Mesh;
    depth: Mesh;
    edges: LineSegments;
    creases: LineSegments[];
  };

  constructor(
    private readonly look: Look,
    edges: Uint32Array,
    creases: Uint32Array,
  ) {
    const outline = (ends: Uint32Array) =>
      new BufferGeometry().setIndex(new BufferAttribute(ends, 1));
    this.outlines = { edges: outline(edges), creases: outline(creases) };
    this.surface = this.shaded();
    this.depth = this.shaded();
    this.depth.colorWrite = false;
    const faces = new Mesh(this.faces, this.surface);
    const depth = new Mesh(this.faces, this.depth);
    depth.visible = false;
    const segments = (geometry: BufferGeometry, material: ShaderMaterial) =>
      new LineSegments(geometry, material);
    this.meshes = {
      faces,
      depth,
      edges: segments(this.outlines.edges, this.lines(EDGES, this.own.edges)),
      creases: [0, 1].map(() =>
        segments(this.outlines.creases, this.lines(CREASES, this.own.creases)),
      ),
    };
    this.group.matrixAutoUpdate = false;
    for (const object of [depth, faces, this.meshes.edges, ...this.meshes.creases]) {
      object.frustumCulled = false;
      this.group.add(object);
    }
  }

  private shaded(): ShaderMaterial {
    return new ShaderMaterial({
      glslVersion: GLSL3,
      vertexShader: SURFACE_VERTEX,
      fragmentShader: SURFACE_FRAGMENT,
      uniforms: { ...this.look.lights, ...this.own },
      defines: { PAINT: PAINT.plain },
      side: DoubleSide,
      polygonOffset: true,
      polygonOffsetFactor: 1,
      polygonOffsetUnits: 1,
    });
  }

  private lines(
    kind: { opacity: number; share: number; pixels: number },
    colour: { value: Color },
  ): ShaderMaterial {
    return new ShaderMaterial({
      glslVersion: GLSL3,
      vertexShader: LINE_VERTEX,
      fragmentShader: LINE_FRAGMENT,
      uniforms: {
        colour,
        pixels: this.own.pixels,
        opacity: uniform(kind.opacity),
        crowding: uniform(new Vector2(kind.share, kind.pixels)),
        shift: uniform(new Vector2()),
      },
      transparent: true,
      depthWrite: false,
    });
  }

  /** Sets the arrays shared by faces, edges and creases. */
  share(positions: BufferAttribute, normals: BufferAttribute, corners: Uint32Array): void {
    for (const geometry of [this.faces, this.outlines.edges, this.outlines.creases]) {
      geometry.dispose();
      geometry.setAttribute("position", positions);
      geometry.setAttribute("normal", normals);
    }
    this.faces.setIndex(new BufferAttribute(corners, 1));
  }

  /** Draws only so many creases, the first ones. */
  creasesUpTo(count: number): void {
    this.outlines.creases.setDrawRange(0, 2 * count);
  }

  /** Sets an array of the faces only. */
  attribute(name: string, values: BufferAttribute | null): void {
    if (values) this.faces.setAttribute(name, values);
    else this.faces.deleteAttribute(name);
  }

  /** Chooses what the colour follows. */
  paint(kind: keyof typeof PAINT, map: Texture | null): void {
    this.own.map.value = map;
    if (this.surface.defines.PAINT === PAINT[kind]) return;
    this.surface.defines.PAINT = PAINT[kind];
    this.surface.needsUpdate = true;
  }

  style(style: SurfaceStyle): void {
    const { meshes, own, surface } = this;
    const through = style.opacity < 1;
    this.group.visible = style.visible && style.opacity > 0;
    plain(own.colour.value, style.colour ?? this.look.palette.clay);
    plain(own.edges.value, style.lineColour ?? this.look.palette.edges);
    plain(own.creases.value, style.creaseColour ?? this.look.palette.creases);
    own.opacity.value = style.opacity;
    own.flatness.value = style.shading === "flat" ? 1 : 0;
    surface.transparent = this.depth.transparent = through;
    surface.depthWrite = !through;
    meshes.depth.visible = through;
    const order = through ? THROUGH : 0;
    meshes.depth.renderOrder = order;
    meshes.faces.renderOrder = order + 1;
    meshes.edges.visible = style.edges;
    meshes.edges.renderOrder = order + 2;
    meshes.faces.visible = style.faces;
    const kind = style.lineColour === null ? EDGES : COLOURED;
    opacityOf(meshes.edges, kind.opacity * Math.sqrt(style.opacity));
    uniformsOf(meshes.edges).crowding!.value.set(kind.share, kind.pixels);
    for (const creases of meshes.creases) {
      creases.visible = style.creases;
      creases.renderOrder = order + 2;
      opacityOf(creases, CREASES.opacity * Math.sqrt(style.opacity));
      const share = style.creaseColour === null ? CREASES.share : 1;
      uniformsOf(creases).crowding!.value.set(share, CREASES.pixels);
    }
  }

  /**
   * @param unit pixels of one unit of the positions, one unit of the scene ahead
   * @param width of the viewport, in pixels of the canvas
   * @param height of the viewport, in pixels of the canvas
   */
  size(unit: number, width: number, height: number): void {
    this.own.pixels.value = unit;
    this.meshes.creases.forEach(({ material }, index) => {
      const side = index === 0 ? -0.5 : 0.5;
      const { shift } = (material as ShaderMaterial).uniforms;
      shift!.value.set(side / width, side / height);
    });
  }

  /** Whether it is drawn, or only its arrays are sent to the graphics card. */
  draw(drawn: boolean): void {
    for (const object of this.group.children) {
      (object as Mesh<BufferGeometry, ShaderMaterial>).material.visible = drawn;
    }
  }

  dispose(): void {
    this.group.removeFromParent();
    for (const object of this.group.children) {
      const { geometry, material } = object as Mesh<BufferGeometry, ShaderMaterial>;
      geometry.dispose();
      material.dispose();
    }
  }
}

const uniformsOf = (lines: LineSegments) => (lines.material as ShaderMaterial).uniforms;

function opacityOf(lines: LineSegments, opacity: number): void {
  uniformsOf(lines).opacity!.value = opacity;
}
