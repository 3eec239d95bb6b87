import type { PickEvent, Point, SurfaceView } from "../viewer/index.ts";
import { CurvatureColours } from "./design/curvature.ts";
import { Drag, draggingMarks, type Held, SURFACE } from "./design/drag.ts";
import { Panel } from "./design/panel.tsx";
import { draw, meantBy, type Picture } from "./design/picture.ts";
import { nearestOfLevel } from "./design/places.ts";
import {
  choose,
  colourOf,
  type DesignState,
  type DesignView,
  levelAt,
  now,
  own,
  type Placed,
  remove,
  reveal,
  workAt,
} from "./design/state.ts";
import type { Studio, Tab } from "./tab.ts";

const CAGE = "cage";
const colours = new CurvatureColours();
let placed: Placed[] = [];
let drawn: Picture["drawn"] = null;
let free: ReadonlySet<number> = new Set();
let drag: Drag | null = null;

export const design: Tab<DesignState, DesignView> = {
  name: "design",
  title: "Design",
  about: "A smooth surface from a coarse cage, through points and curves.",
  viewports: 1,
  tools: [
    {
      name: "orbit",
      title: "Turn the view",
      icon: "orbit",
      keys: "V",
      viewport: "orbit",
      hint: "Drag to turn, wheel to zoom, Shift to move. Drag a pin to move it",
    },
    {
      name: "pin",
      title: "Pin",
      icon: "pin",
      keys: "P",
      viewport: "pick",
      hint: "Click the surface to pin a vertex of the level; then drag the pin",
    },
    {
      name: "curve",
      title: "Curve",
      icon: "curve",
      keys: "C",
      viewport: "pick",
      hint: "Click points along the surface; Enter ends the curve, its first point closes it",
    },
    {
      name: "hold",
      title: "Hold vertices of the cage",
      icon: "pick",
      keys: "H",
      viewport: "pick",
      hint: "Click a vertex of the cage to let it go (orange), or to hold it again (grey)",
    },
  ],
  shortcuts: [
    {
      keys: "Delete / Backspace",
      does: "Remove what is chosen",
      run: (studio) => void remove(studio, own.chosen),
    },
    { keys: "Enter", does: "End the curve", run: (studio) => void endCurve(studio) },
    { keys: "[", does: "Work at a coarser level", run: (studio) => void step(studio, -1) },
    { keys: "]", does: "Work at a finer level", run: (studio) => void step(studio, 1) },
    {
      keys: "O",
      does: "Show or hide the cage",
      run: (studio) => {
        own.cage = !own.cage;
        studio.changed();
      },
    },
  ],
  Panel,

  async scene(studio, state, view) {
    await takeIn(studio, state, view);
    await bringSurfaces(studio, state, view);
    if (drag?.done) drag = null;
    picture(studio);
    gizmo(studio);
  },

  enter(studio) {
    const viewport = studio.viewports[0]!;
    viewport.element.classList.add("aimed");
    return [
      () => viewport.element.classList.remove("aimed"),
      viewport.on("pick", (hit) => void click(studio, hit)),
      viewport.on("hover", (hit) => {
        const vertex = hit && vertexAt(studio, hit);
        if (vertex === own.hover) return;
        own.hover = vertex;
        picture(studio);
      }),
      draggingMarks(viewport, (mark) => heldBy(studio, mark)),
    ];
  },

  leave() {
    drag = null;
    own.hover = null;
    colours.forget();
  },

  frame(message, studio) {
    const surface = studio.viewports[0]!.surface(SURFACE);
    if (message.header.surface === SURFACE && surface) colours.follow(surface);
  },

  basis(message) {
    drag?.answered(message);
  },

  use: (studio, mesh) => void studio.do("design", "use", { slot: CAGE, mesh }),

  tool(studio) {
    own.hover = null;
    studio.changed();
  },

  escape(studio) {
    if (now(studio)?.state.stroke) void studio.do("design", "drop_curve");
    else if (own.chosen !== null && studio.tool.name === "orbit") choose(studio, null);
    else return false;
    return true;
  },
};

/** Has all lists of the view at hand. */
async function takeIn(studio: Studio, state: DesignState, view: DesignView): Promise<void> {
  const { stroke } = state;
  const numbers = async (list: DesignView["free"] | undefined) =>
    Array.from(list ? await studio.numbers(list) : []);
  placed = await Promise.all(
    (view.parts ?? []).map(async (part) => {
      const path = part.vertex === undefined ? await numbers(part.path) : [part.vertex];
      return { part, path, line: triples(await numbers(part.to)) };
    }),
  );
  drawn = stroke && {
    level: stroke.level,
    path: await numbers(view.path),
    through: await numbers(stroke.through),
  };
  free = new Set(await numbers(view.free));
  if (!placed.some(({ part }) => part.name === own.chosen)) own.chosen = own.point = null;
}

async function bringSurfaces(studio: Studio, state: DesignState, view: DesignView): Promise<void> {
  const viewport = studio.viewports[0]!;
  for (const key of viewport.keys) if (!view.surfaces[key]) viewport.remove(key);
  const { surface: main, cage } = view.surfaces;
  if (main) {
    const data = await studio.surface(main.data);
    if (viewport.surface(SURFACE)?.data !== data) {
      viewport.add(SURFACE, data);
      colours.forget();
    }
    const surface = viewport.surface(SURFACE)!;
    const shown = view.shown ?? 0;
    const level = Math.min(aimedLevel(studio, state, view), shown);
    const { edges, shading } = studio.look;
    const finest = level === shown;
    surface.style({ shading, edges: edges && finest, creases: edges && !finest });
    surface.creasesUpTo(view.grid[level]!);
    colours.show(viewport, surface, own.curvature);
  }
  if (cage) {
    const data = await studio.surface(cage.data);
    const known = viewport.surface(CAGE);
    const alone = !main;
    if (!known || known.data.positions !== data.positions || known.solid !== alone) {
      viewport.add(CAGE, alone ? data : linesOf(data), { solid: alone });
    }
    viewport.surface(CAGE)!.style({ visible: alone || own.cage });
  }
}

/** Only the edges of a surface. */
function linesOf(data: SurfaceView["data"]): SurfaceView["data"] {
  const none = new Uint32Array(0);
  return { ...data, triangles: none, face: none, edges: none, creases: data.edges };
}

/** Draws marks and lines as they are now. */
function picture(studio: Studio): void {
  const here = now(studio);
  const viewport = studio.viewports[0];
  if (!here || !viewport) return;
  const { state, view } = here;
  const holding = studio.tool.name === "hold" && view.levels;
  draw(viewport, {
    placed,
    drag,
    drawn,
    cage: holding ? { count: view.levels[0]!.vertices, free } : null,
    hover:
      own.hover === null
        ? null
        : { vertex: own.hover, colour: colourOf(aimedLevel(studio, state, view)) },
  });
}

/** The level whose vertices clicks mean. */
const aimedLevel = (studio: Studio, state: DesignState, view: DesignView) =>
  studio.tool.name === "hold" ? 0 : levelAt(state, view);

/** The vertex that a hit means with the tool in hand; null for none. */
function vertexAt(studio: Studio, hit: { surface: string } & Parameters<typeof nearestOfLevel>[1]) {
  const here = now(studio);
  const surface = studio.viewports[0]!.surface(SURFACE);
  if (!here || !surface || hit.surface !== SURFACE || studio.tool.viewport !== "pick") return null;
  const { state, view } = here;
  const level = aimedLevel(studio, state, view);
  const finer = (view.shown ?? 0) - level;
  if (finer < 0 || !view.levels) return null; // of a tab that is on its way to the front
  return nearestOfLevel(surface, hit, view.levels[level]!.vertices, 2 ** finer);
}

async function click(studio: Studio, hit: PickEvent): Promise<void> {
  const here = now(studio);
  const vertex = vertexAt(studio, hit);
  if (!here) return;
  const level = aimedLevel(studio, here.state, here.view);
  if (vertex === null) {
    if (level > (here.view.shown ?? 0)) {
      studio.notify("info", `The curve is drawn at level ${level}; show that level to go on.`);
    }
    return;
  }
  if (studio.tool.name === "pin") {
    const known = new Set(here.view.parts?.map((part) => part.name));
    if (!(await studio.do("design", "add_pin", { level, vertex }))) return;
    const added = now(studio)?.view.parts?.find(({ name }) => !known.has(name));
    if (added) choose(studio, added.name);
  } else if (studio.tool.name === "curve") {
    await studio.do("design", "draw", { level, vertex });
  } else if (studio.tool.name === "hold") {
    await studio.do("design", "hold", { vertices: [vertex], held: free.has(vertex) });
  }
}

/** What a mark is, where it can be dragged. */
function heldBy(studio: Studio, mark: string): Held | null {
  const meant = meantBy(mark);
  if (!meant || !["orbit", "pin"].includes(studio.tool.name)) return null;
  const name = "name" in meant ? meant.name : own.chosen;
  const point = "name" in meant ? null : meant.index;
  const one = placed.find(({ part }) => part.name === name);
  if (!one || one.line.length === 0) return null;
  return {
    position: one.line[point ?? middleOf(one)]!,
    click: () => choose(studio, one.part.name, point),
    begin: () => {
      studio.viewports[0]!.gizmo.detach();
      return begin(studio, one, point);
    },
  };
}

function begin(studio: Studio, one: Placed, point: number | null): Drag {
  own.chosen = one.part.name;
  own.point = point;
  drag = new Drag(studio, one, point, () => {
    const surface = studio.viewports[0]!.surface(SURFACE);
    if (surface) colours.follow(surface);
    picture(studio);
  });
  studio.changed();
  reveal();
  return drag;
}

/** Puts the arrows where what is chosen is. */
function gizmo(studio: Studio): void {
  const viewport = studio.viewports[0]!;
  if (drag) return;
  const one = placed.find(({ part }) => part.name === own.chosen);
  const position = one?.line[own.point ?? middleOf(one)];
  if (!one || !position || !["orbit", "pin"].includes(studio.tool.name)) {
    viewport.gizmo.detach();
    return;
  }
  let held: Drag | null = null;
  const to = (by: Point) => {
    held ??= begin(studio, one, own.point);
    held.to(by);
  };
  viewport.gizmo.attach(
    { position },
    {
      onChange: ({ translation }) => to(translation),
      onEnd: () => {
        void held?.end();
        studio.changed(); // where it was cancelled, the arrows go back now
      },
    },
  );
}

/** The point of a line that stands for it. */
const middleOf = ({ part, line }: Placed) =>
  part.kind === "pins" ? 0 : Math.floor(line.length / 2);

async function endCurve(studio: Studio): Promise<void> {
  const known = new Set(now(studio)?.view.parts?.map((part) => part.name));
  if (!now(studio)?.state.stroke || !(await studio.do("design", "end_curve"))) return;
  studio.take("orbit");
  const added = now(studio)?.view.parts?.find(({ name }) => !known.has(name));
  if (added) choose(studio, added.name);
}

async function step(studio: Studio, by: number): Promise<void> {
  const here = now(studio);
  if (here && !here.state.stroke) await workAt(studio, levelAt(here.state, here.view) + by);
}

function triples(numbers: readonly number[]): Point[] {
  return Array.from({ length: numbers.length / 3 }, (_, k) => [
    numbers[3 * k]!,
    numbers[3 * k + 1]!,
    numbers[3 * k + 2]!,
  ]);
}
