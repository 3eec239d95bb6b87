/** The colours and tints of a surface's vertices and faces. */
import { provoking, VertexArray, type Provoking } from "./buffers";
import { coloured, shares, textureOf, type Colormap } from "./colormaps";
import type { Drawn } from "./drawn";
import { bytes, type Look } from "./themes";
import type { Region, SurfaceData } from "./types";

/** Colours by values and a colour map, or as they are; of vertices or of faces. */
export type Colours =
  | {
      /** (n,) or (faces,); what is no number stays the surface's own colour. */
      values: ArrayLike<number>;
      per: "vertex" | "face";
      /** `categorical` takes whole numbers, of patches say. */
      colormap: Colormap;
      min: number;
      max: number;
    }
  | {
      /** (n, 3) or (faces, 3). */
      rgb: Uint8Array;
      per: "vertex" | "face";
    };

export class Paint {
  private provoked: Provoking | null = null;
  private copies: Uint32Array = new Uint32Array(0);
  private tints!: VertexArray<Uint8Array>;
  private values: VertexArray | null = null;
  private colours: VertexArray<Uint8Array> | null = null;
  private regions: readonly Region[] = [];
  private stroke: Region | null = null;

  constructor(
    private readonly data: SurfaceData,
    private readonly drawn: Drawn,
    private readonly look: Look,
  ) {}

  /** How each face gets a vertex of its own. */
  get faces(): Provoking {
    const { triangles, face, positions } = this.data;
    return (this.provoked ??= provoking(triangles, face, positions.length / 3));
  }

  /** Makes the arrays anew, for all vertices and copies of some. */
  allot(copies: Uint32Array): void {
    this.copies = copies;
    this.values = this.colours = null;
    this.tints = new VertexArray(new Uint8Array(4 * this.entries), 4, copies, true);
    this.drawn.attribute("tint", this.tints.attribute);
    this.drawn.attribute("value", null);
    this.drawn.attribute("paint", null);
    if (this.regions.length > 0 || this.stroke) this.tint();
  }

  private get entries(): number {
    return this.data.positions.length / 3 + this.copies.length;
  }

  /** Colours all vertices or faces; null for the surface's own colour. */
  apply(colours: Colours | null): void {
    if (!colours) this.drawn.paint("plain", null);
    else if (colours.per === "face") this.applyRgb(this.rgb(colours), "faces");
    else if ("rgb" in colours) this.applyRgb(colours.rgb, "vertices");
    else if (colours.colormap === "categorical") this.applyRgb(this.rgb(colours), "vertices");
    else {
      this.values ??= this.made(
        "value",
        new VertexArray(new Float32Array(this.entries), 1, this.copies),
      );
      this.values.values.set(shares(colours.values, colours.min, colours.max));
      this.values.changed();
      this.drawn.paint("values", textureOf(colours.colormap));
    }
  }

  private rgb(colours: Colours): Uint8Array {
    if ("rgb" in colours) return colours.rgb;
    const blank = bytes(this.look.palette.clay);
    return coloured(colours.values, colours.colormap, colours.min, colours.max, blank);
  }

  private applyRgb(rgb: Uint8Array, kind: "vertices" | "faces"): void {
    const none = new Uint32Array(0);
    const paint = new Uint8Array(4 * this.entries);
    this.colours ??= this.made("paint", new VertexArray(paint, 4, none, true));
    const { values } = this.colours;
    const owners = kind === "faces" ? this.faces.face : null;
    for (let entry = 0; entry < values.length / 4; entry++) {
      const from = 3 * (owners ? Math.max(0, owners[entry]!) : entry);
      values[4 * entry] = rgb[from]!;
      values[4 * entry + 1] = rgb[from + 1]!;
      values[4 * entry + 2] = rgb[from + 2]!;
    }
    this.colours.changed();
    this.drawn.paint(kind, null);
  }

  private made<Made extends VertexArray<Float32Array> | VertexArray<Uint8Array>>(
    name: string,
    array: Made,
  ): Made {
    this.drawn.attribute(name, array.attribute);
    return array;
  }

  /** Tints groups of vertices, and no others. */
  tintRegions(regions: readonly Region[]): void {
    this.regions = regions;
    this.stroke = null;
    this.tint();
  }

  /** Tints vertices over the regions until those are next set; null for none. */
  tintStroke(stroke: Region | null): void {
    this.stroke = stroke;
    this.tint();
  }

  private tint(): void {
    const { values } = this.tints;
    values.fill(0);
    for (const { ids, colour } of this.stroke ? [...this.regions, this.stroke] : this.regions) {
      const [red, green, blue] = bytes(colour);
      for (let i = 0; i < ids.length; i++) {
        const to = 4 * ids[i]!;
        values[to] = red;
        values[to + 1] = green;
        values[to + 2] = blue;
        values[to + 3] = 255;
      }
    }
    this.tints.changed();
  }
}
