import { tabs } from "../tabs/index.ts";
import { IconButton, Menu, Sign } from "../ui/index.ts";
import type { App } from "./app.ts";
import { Exports } from "./exports.tsx";
import { openFiles } from "./shortcuts.ts";
import { theme } from "./theme.ts";

/** The bar at the top: tabs, and what can be done anywhere. */
export function TopBar({ app }: { app: App }) {
  const { state } = app;
  return (
    <header class="topbar">
      <Menu
        label="henkei"
        lead={<Sign />}
        items={[
          { label: "Open…", icon: "open", keys: "Ctrl+O", onSelect: openFiles },
          { label: "Examples and earlier work…", icon: "list", onSelect: () => app.show("start") },
          "line",
          {
            label: "Begin anew",
            icon: "plus",
            detail: "What is open is kept, and offered on the start page",
            disabled: app.isEmpty,
            onSelect: () => void app.begin("new"),
          },
          "line",
          {
            label: "Slow connection",
            detail: "Half the bytes while dragging, at 16 bits; exact when it is let go",
            checked: app.slow,
            onSelect: () => (app.slow = !app.slow),
          },
        ]}
      />
      <nav role="tablist" aria-label="Methods" onKeyDown={walk}>
        {tabs.map((tab, k) => (
          <button
            key={tab.name}
            type="button"
            role="tab"
            id={`tab-${tab.name}`}
            aria-selected={tab === app.tab}
            aria-controls="panel"
            tabIndex={tab === app.tab ? 0 : -1}
            title={`${tab.about} (${k + 1})`}
            onClick={() => app.open(tab.name)}
          >
            {tab.title}
          </button>
        ))}
      </nav>
      <span class="gap" />
      <IconButton
        icon="undo"
        label="Undo"
        hint={state?.undo ?? undefined}
        keys="Ctrl+Z"
        disabled={!state?.undo}
        onClick={() => void app.undo()}
      />
      <IconButton
        icon="redo"
        label="Redo"
        hint={state?.redo ?? undefined}
        keys="Ctrl+Shift+Z"
        disabled={!state?.redo}
        onClick={() => void app.redo()}
      />
      <span class="rule" />
      <IconButton icon="open" label="Open" keys="Ctrl+O" onClick={openFiles} />
      <Exports app={app} />
      <span class="rule" />
      <IconButton
        icon={theme() === "dark" ? "sun" : "moon"}
        label={theme() === "dark" ? "Light theme" : "Dark theme"}
        onClick={() => app.switchTheme()}
      />
      <IconButton icon="help" label="Help" keys="?" onClick={() => app.show("help")} />
    </header>
  );
}

/** Arrow keys go from tab to tab. */
function walk(event: KeyboardEvent & { currentTarget: HTMLElement }) {
  const by = { ArrowRight: 1, ArrowLeft: -1 }[event.key];
  if (!by) return;
  const buttons = [...event.currentTarget.querySelectorAll("button")];
  const at = buttons.indexOf(document.activeElement as HTMLButtonElement);
  const next = buttons.at((at + by) % buttons.length);
  next?.focus();
  next?.click();
}
