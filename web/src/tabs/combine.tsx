/** Combining: pairs are marked on two meshes, and one mesh with both forms comes of it. */

import { page } from "./combine/page.ts";
import { Panel } from "./combine/panel.tsx";
import { forget, scene, toTime } from "./combine/scenes.ts";
import type { CombineState, CombineView } from "./combine/types.ts";
import type { Studio, Tab } from "./tab.ts";

export const combine: Tab<CombineState, CombineView> = {
  name: "combine",
  title: "Combine",
  about: "Two surfaces become one mesh with both forms, and morph into each other.",
  viewports: 2,
  tools: [
    {
      name: "pairs",
      title: "Boundary pair",
      icon: "link",
      keys: "B",
      viewport: "pick",
      hint: "Click a boundary vertex on the left, then its partner on the right; drag marks to move them",
    },
    {
      name: "landmarks",
      title: "Landmark",
      icon: "pin",
      keys: "L",
      viewport: "pick",
      hint: "Click a vertex inside the left surface, then its partner on the right; drag marks to move them",
    },
    {
      name: "orbit",
      title: "Turn the view",
      icon: "orbit",
      keys: "V",
      viewport: "orbit",
      hint: "Drag to turn, wheel to zoom, Shift to move",
    },
  ],
  shortcuts: [
    { keys: "Enter", does: "Combine", run: () => void page.combine() },
    { keys: "Space", does: "Play the morph, or stop it", run: () => play() },
    {
      keys: "Delete / Backspace",
      does: "Remove the selected pair",
      run: (studio) => remove(studio),
    },
    { keys: "S", does: "Side by side", run: () => page.show("sides") },
    { keys: "P", does: "Flattened, in the common plane", run: () => page.show("plane") },
    { keys: "M", does: "Morph", run: () => page.show("morph") },
  ],
  Panel,
  async scene(studio, state, view) {
    page.player.seconds = state.recipe.morph.seconds;
    const arrived = page.awaited && (view.result?.current ?? false);
    if (arrived) page.arrive();
    await scene(studio, state, view);
    if (arrived) show();
  },
  enter(studio) {
    page.studio = studio;
    forget();
    page.pairing.take(studio.tool.name === "orbit" ? null : studio.tool.name);
    return [
      ...page.pairing.enter(studio),
      page.player.subscribe(() => toTime(studio)),
      () => page.player.stop(),
    ];
  },
  use(studio, mesh) {
    const { a, b } = studio.state!.tabs.combine.state as CombineState;
    const slot = a === null || b !== null ? "a" : "b";
    if (mesh !== a && mesh !== b) void studio.do("combine", "use", { slot, mesh });
  },
  tool: (_, tool) => page.hold(tool.name),
  escape: () => page.pairing.escape(),
};

/** Shows once what was made: from a to b, or halfway where people want less motion. */
function show(): void {
  if (matchMedia("(prefers-reduced-motion: reduce)").matches) page.player.seek(0.5);
  else page.player.play(true);
}

function play(): void {
  if (page.mode !== "morph") page.show("morph");
  if (page.mode === "morph") page.player.toggle();
}

function remove(studio: Studio): void {
  const { chosen } = page.pairing;
  if (chosen) void studio.do("combine", "remove_pair", chosen);
}
