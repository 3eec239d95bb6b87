import { Icon, IconButton, keysTitle, Menu } from "../ui/index.ts";
import type { App } from "./app.ts";

/** The tools of the tab, at the stage's left. */
export function ToolBar({ app }: { app: App }) {
  const { tools } = app.tab;
  if (tools.length < 2) return null;
  return (
    <div class="toolbar" role="toolbar" aria-label="Tools" aria-orientation="vertical">
      {tools.map((tool) => (
        <button
          key={tool.name}
          type="button"
          class="icon-button"
          aria-label={tool.title}
          aria-pressed={tool === app.tool}
          title={keysTitle(tool.title, tool.keys)}
          onClick={() => app.take(tool.name)}
        >
          <Icon name={tool.icon} size={18} />
        </button>
      ))}
    </div>
  );
}

const sides = ["front", "back", "left", "right", "top", "bottom"] as const;

/** How the surfaces are seen, at the stage's right. */
export function ViewBar({ app }: { app: App }) {
  const { look } = app;
  return (
    <div class="viewbar" role="toolbar" aria-label="View">
      <IconButton
        icon="edges"
        label="Edges"
        keys="E"
        pressed={look.edges}
        onClick={() => app.switchEdges()}
      />
      <IconButton
        icon={look.shading === "smooth" ? "smooth" : "flat"}
        label="Smooth shading"
        pressed={look.shading === "smooth"}
        onClick={() => app.setLook({ shading: look.shading === "smooth" ? "flat" : "smooth" })}
      />
      <Menu
        label="View from"
        icon="view"
        bare
        align="right"
        items={[
          ...sides.map((side) => ({
            label: side[0]!.toUpperCase() + side.slice(1),
            onSelect: () => app.viewports.forEach((viewport) => viewport.view(side)),
          })),
          "line",
          {
            label: "Z is up",
            checked: app.upward === "z",
            onSelect: () => app.turnUpward(app.upward === "z" ? "y" : "z"),
          },
        ]}
      />
      <IconButton icon="frame" label="Fit" keys="F" onClick={() => app.frame()} />
    </div>
  );
}
