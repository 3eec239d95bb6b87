/** Registering: a source takes on the form of a target, and is seen to do so. */

import { receive } from "./register/files.ts";
import { Gliding } from "./register/gliding.ts";
import { MARKS, page } from "./register/page.ts";
import { Panel } from "./register/panel.tsx";
import { forget, LIVE, scene, toTime } from "./register/scenes.ts";
import type { RegisterState, RegisterView } from "./register/types.ts";
import type { Tab } from "./tab.ts";

const gliding = new Gliding();

export const register: Tab<RegisterState, RegisterView> = {
  name: "register",
  title: "Register",
  about: "One mesh takes on the form of another, vertex for vertex.",
  viewports: 2,
  tools: [
    {
      name: MARKS,
      title: "Landmark",
      icon: "pin",
      keys: "L",
      viewport: "pick",
      hint: "Click a place on the source, then the same place on the target; drag marks to move them",
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
    { keys: "Enter", does: "Register", run: () => void page.register() },
    { keys: "Space", does: "Play the morph, or stop it", run: () => play() },
    { keys: "Delete / Backspace", does: "Remove the selected landmark", run: remove },
    { keys: "S", does: "Both meshes, side by side", run: () => page.show("sides") },
    { keys: "M", does: "The model over the target", run: () => page.show("model") },
  ],
  Panel,
  async scene(studio, state, view) {
    page.player.seconds = state.recipe.morph.seconds;
    page.follow(view);
    await scene(studio, state, view);
  },
  enter(studio) {
    page.studio = studio;
    forget();
    page.pairing.take(studio.tool.name === MARKS ? MARKS : null);
    return [
      ...page.pairing.enter(studio),
      page.player.subscribe(() => toTime(studio)),
      () => page.player.stop(),
      () => gliding.stop(),
    ];
  },
  frame({ header }, studio) {
    const [viewport] = studio.viewports;
    const surface = header.surface === LIVE && viewport?.surface(LIVE);
    if (!surface) return;
    const first = gliding.take(surface);
    if (first) viewport!.frame();
  },
  use(studio, mesh) {
    const { source, target } = studio.state!.tabs.register.state as RegisterState;
    const slot = source === null || target !== null ? "source" : "target";
    if (mesh !== source && mesh !== target) void studio.do("register", "use", { slot, mesh });
  },
  tool: (_, tool) => page.hold(tool.name),
  escape: () => page.pairing.escape(),
  receive,
};

function play(): void {
  if (page.shown !== "model") page.show("model");
  if (page.shown === "model" && !page.job) page.player.toggle();
}

function remove(): void {
  const { chosen } = page.pairing;
  if (chosen) page.remove(chosen.index);
}
