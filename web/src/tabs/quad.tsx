/** Quads of any mesh: how many, along which edges, and how good they are. */

import { page, type Sight } from "./quad/page.ts";
import { Panel } from "./quad/panel.tsx";
import { inspect, scene } from "./quad/scene.ts";
import type { QuadState, QuadView } from "./quad/types.ts";
import type { Shortcut, Tab } from "./tab.ts";

const look = (keys: string, sight: Sight, does: string): Shortcut => ({
  keys,
  does,
  run: () => page.show(sight),
});

const toggle = (keys: string, name: keyof typeof page.shown, does: string): Shortcut => ({
  keys,
  does,
  run: () => page.set({ [name]: !page.shown[name] }),
});

export const quad: Tab<QuadState, QuadView> = {
  name: "quad",
  title: "Quad",
  about: "A surface in quads that follow its shape.",
  viewports: 1,
  tools: [
    {
      name: "orbit",
      title: "Turn the view",
      icon: "orbit",
      viewport: "orbit",
      hint: "Drag to turn, wheel to zoom, Shift to move; hold C to compare quads and input",
    },
  ],
  shortcuts: [
    { keys: "Enter", does: "Make quads", run: () => void page.make("quads") },
    look("Q", "quads", "Quads"),
    look("W", "quality", "Quality of the quads"),
    look("P", "patches", "Patches"),
    look("I", "input", "Input"),
    { keys: "C", does: "Hold: compare quads and input", run: () => page.compare(true) },
    toggle("V", "irregular", "Irregular vertices"),
    toggle("L", "arcs", "Patch boundaries"),
    toggle("G", "features", "Creases and boundaries"),
  ],
  Panel,
  async scene(studio, state, view) {
    page.arrive(view);
    await scene(studio, state, view);
  },
  enter(studio) {
    page.studio = studio;
    page.comparing = false;
    const ended = new AbortController();
    const { signal } = ended;
    const released = (event: KeyboardEvent) =>
      event.key.toLowerCase() === "c" && page.compare(false);
    addEventListener("keyup", released, { signal });
    addEventListener("blur", () => page.compare(false), { signal });
    const hover = studio.viewports[0]!.on("hover", (hit) => inspect(studio, hit));
    return [() => ended.abort(), hover];
  },
  use: (studio, mesh) => void studio.do("quad", "use", { slot: "mesh", mesh }),
};
