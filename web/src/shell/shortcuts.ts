import { tabs } from "../tabs/index.ts";
import { belongsToFocus, type HelpPart, pressed } from "../ui/index.ts";
import type { App } from "./app.ts";

type GlobalShortcut = { keys: string; does: string; run(app: App): void };

export const openFiles = () => document.querySelector<HTMLInputElement>("#files")!.click();

export const shortcuts: readonly GlobalShortcut[] = [
  { keys: "Ctrl+Z", does: "Undo", run: (app) => void app.undo() },
  { keys: "Ctrl+Shift+Z / Ctrl+Y", does: "Redo", run: (app) => void app.redo() },
  { keys: "Ctrl+O", does: "Open files", run: openFiles },
  { keys: "F", does: "Fit the view", run: (app) => app.frame() },
  {
    keys: "E",
    does: "Show or hide edges",
    run: (app) => app.switchEdges(),
  },
  ...tabs.map((tab, k) => ({
    keys: String(k + 1),
    does: `${tab.title} tab`,
    run: (app: App) => app.open(tab.name),
  })),
  { keys: "?", does: "This list", run: (app) => app.show(app.overlay === "help" ? null : "help") },
  { keys: "Escape", does: "Back: close, or put the tool away", run: (app) => app.escape() },
];

const mouse: HelpPart = {
  title: "Mouse",
  rows: [
    { keys: "Drag", does: "What the tool does" },
    { keys: "Right drag / Alt + drag", does: "Turn the view" },
    { keys: "Shift + right drag", does: "Move the view" },
    { keys: "Wheel", does: "Zoom" },
    { keys: "Drop files", does: "Open them, anywhere on the page" },
  ],
};

/** Has the keyboard do what the shortcuts say: the tab's first, then those of the page. */
export function listenToKeys(app: App): void {
  let dragging = false; // then Escape ends the drag
  for (const [event, is] of [
    ["pointerdown", true],
    ["pointerup", false],
    ["pointercancel", false],
  ] as const)
    addEventListener(event, () => (dragging = is), true);
  // a release over a menu of the browser's own is not told
  addEventListener("pointermove", ({ buttons }) => (dragging &&= buttons !== 0), true);
  addEventListener("click", (event) => {
    // after a click by mouse, Space is not for that button
    const button = (event.target as Element).closest("button:not([aria-haspopup])");
    if (event.detail > 0 && !button?.closest("dialog")) (button as HTMLElement | null)?.blur();
  });
  addEventListener("keydown", (event) => {
    if (event.defaultPrevented || dragging || belongsToFocus(event)) return;
    if (document.querySelector("dialog[open]")) return; // it has the keyboard
    const { tab } = app;
    const used =
      app.overlay === "start" || app.isEmpty
        ? undefined
        : (tab.shortcuts.find((one) => pressed(event, one.keys)) ??
          tab.tools
            .filter((tool) => tool.keys && pressed(event, tool.keys))
            .map((tool) => ({ run: () => app.take(tool.name) }))[0]);
    const run = used ?? shortcuts.find((one) => pressed(event, one.keys));
    if (!run) return;
    event.preventDefault();
    run.run(app);
  });
}

/** Everything that keys and mouse do now. */
export function help(app: App): HelpPart[] {
  const tools = app.tab.tools.filter((tool) => tool.keys);
  return [
    { title: "Everywhere", rows: shortcuts },
    mouse,
    { title: app.tab.title, rows: app.tab.shortcuts },
    {
      title: `Tools of ${app.tab.title}`,
      rows: tools.map((tool) => ({ keys: tool.keys!, does: tool.title })),
    },
  ];
}
