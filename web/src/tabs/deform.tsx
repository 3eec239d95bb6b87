import { belongsToFocus, Hint, Note, pressed } from "../ui/index.ts";
import { FoundOnSurface } from "./deform/found.tsx";
import { recolour } from "./deform/heat.ts";
import { memory, resizeBrush, stateOf, unchoose, viewOf } from "./deform/memory.ts";
import { blend, dropMoving, takeBasis } from "./deform/moving.ts";
import { Parts } from "./deform/parts.tsx";
import { dropPinning, letPinsBeDragged } from "./deform/pinning.ts";
import { Result } from "./deform/result.tsx";
import { forget, scene } from "./deform/scene.ts";
import {
  add,
  click,
  removeChosen,
  selectNothing,
  selectOutlined,
  selectStroked,
} from "./deform/selecting.ts";
import { Selection } from "./deform/selection.tsx";
import { Settings } from "./deform/settings.tsx";
import type { DeformState, DeformView } from "./deform/types.ts";
import type { Studio, Tab } from "./tab.ts";

const modes = "Shift adds, Ctrl takes away";

export const deform: Tab<DeformState, DeformView> = {
  name: "deform",
  title: "Deform",
  about: "Drag parts of a surface; its details and features follow.",
  viewports: 1,
  tools: [
    {
      name: "move",
      title: "Move parts",
      icon: "move",
      keys: "M",
      viewport: "pick",
      hint: "Click on a part to choose it, drag its arrows and rings; drag elsewhere to turn the view",
    },
    {
      name: "rectangle",
      title: "Select by rectangle",
      icon: "rectangle",
      keys: "R",
      viewport: "rectangle",
      hint: `Drag a rectangle around vertices; ${modes}; right drag turns the view`,
    },
    {
      name: "lasso",
      title: "Select by lasso",
      icon: "lasso",
      keys: "L",
      viewport: "lasso",
      hint: `Draw around vertices; ${modes}; right drag turns the view`,
    },
    {
      name: "brush",
      title: "Paint a selection",
      icon: "brush",
      keys: "B",
      viewport: "brush",
      hint: `Paint over the surface; ${modes}; [ and ] size the brush; right drag turns the view`,
    },
    {
      name: "vertices",
      title: "Select single vertices",
      icon: "pick",
      keys: "V",
      viewport: "pick",
      hint: `Click on vertices to select them or not; ${modes}; drag turns the view`,
    },
    {
      name: "pin",
      title: "Pin points",
      icon: "pin",
      keys: "P",
      viewport: "pick",
      hint: "Click on the surface to pin it there; drag a pin to move it",
    },
  ],
  shortcuts: [
    { keys: "X", does: "Fix the selection", run: (studio) => void add(studio, "fixed") },
    { keys: "H", does: "Make it a handle", run: (studio) => void add(studio, "handles") },
    { keys: "K", does: "Make it a feature", run: (studio) => void add(studio, "features") },
    {
      keys: "G",
      does: "Grow the selection",
      run: (studio) => void studio.do("deform", "grow", { rings: 1 }),
    },
    {
      keys: "Shift+G",
      does: "Shrink the selection",
      run: (studio) => void studio.do("deform", "grow", { rings: -1 }),
    },
    {
      keys: "I",
      does: "Invert the selection",
      run: (studio) => void studio.do("deform", "invert"),
    },
    { keys: "N", does: "Select nothing", run: (studio) => void selectNothing(studio) },
    {
      keys: "Delete / Backspace",
      does: "Remove the chosen part",
      run: (studio) => void removeChosen(studio),
    },
    { keys: "[", does: "Smaller brush", run: (studio) => resizeBrush(studio, 1 / 1.2) },
    { keys: "]", does: "Larger brush", run: (studio) => resizeBrush(studio, 1.2) },
    { keys: "C", does: "Hold: see the surface at rest", run: (studio) => compare(studio, true) },
  ],
  Panel: ({ state, view, studio }) => {
    if (!state.mesh) return <Hint>Choose a mesh in the list above, or open one.</Hint>;
    return (
      <>
        {view.trouble ? <Note level="error">{view.trouble}</Note> : null}
        {view.preparing && (
          <Note level="info">
            Large meshes take a while to prepare. Then handles can be dragged; until then, go on, or
            undo.
          </Note>
        )}
        {view.next && !view.trouble && !view.preparing ? (
          <Note level="info">{view.next}</Note>
        ) : null}
        <Selection view={view} studio={studio} />
        <FoundOnSurface state={state} view={view} studio={studio} />
        <Parts view={view} studio={studio} />
        <Settings state={state} view={view} studio={studio} />
        <Result view={view} studio={studio} />
      </>
    );
  },
  scene,
  enter(studio) {
    forget();
    const viewport = studio.viewports[0]!;
    return [
      viewport.on("outline", (event) => selectOutlined(studio, event)),
      viewport.on("stroke", (event) => void selectStroked(studio, event)),
      viewport.on("pick", (event) => void click(studio, event)),
      viewport.on("miss", () => memory.part && unchoose(studio)),
      letPinsBeDragged(studio, viewport),
      listenToKeys(studio),
    ];
  },
  leave(studio) {
    memory.comparing = false;
    memory.hovered = null;
    studio.hint(null);
  },
  frame(message, studio) {
    if (!blend(studio)) recolour(studio, message.header.exact);
  },
  basis: (message, studio) => takeBasis(studio, message),
  use: (studio, mesh) => void studio.do("deform", "use", { slot: "mesh", mesh }),
  tool: (studio) => studio.changed(),
  escape(studio) {
    if (memory.part) unchoose(studio);
    else if ((viewOf(studio)?.selected ?? 0) > 0) void selectNothing(studio);
    else return false;
    return true;
  },
};

/** Shows the surface at rest in place of the deformed one. */
function compare(studio: Studio, comparing: boolean): void {
  if (memory.comparing === comparing || !stateOf(studio)?.mesh) return;
  memory.comparing = comparing;
  studio.changed();
}

/** Keys that are held, and Escape during a drag. */
function listenToKeys(studio: Studio): () => void {
  const ended = new AbortController();
  const options = { capture: true, signal: ended.signal };
  addEventListener(
    "keydown",
    (event) => {
      if (event.key !== "Escape" || belongsToFocus(event)) return;
      if (dropMoving(studio) || dropPinning(studio)) event.stopPropagation();
    },
    options,
  );
  addEventListener("keyup", (event) => pressed(event, "C") && compare(studio, false), options);
  addEventListener("blur", () => compare(studio, false), options);
  return () => ended.abort();
}
