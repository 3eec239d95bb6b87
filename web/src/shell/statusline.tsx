import { count } from "../ui/index.ts";
import type { App } from "./app.ts";

const told = {
  connecting: "Connecting…",
  connected: "Connected",
  away: "The studio's server is away",
  locked: "The studio's server does not let this page in",
};

/** The line at the bottom: what to do now, what was done last, and how large it is. */
export function StatusLine({ app }: { app: App }) {
  const { state, status } = app;
  return (
    <footer class="statusline">
      <span class="status-hint" role="status" aria-label="Hint">
        {app.isEmpty ? "Open a mesh to begin" : (app.hinted ?? app.tool.hint)}
      </span>
      <span class="gap" />
      {state?.undo && <span class="status-last">Last: {state.undo}</span>}
      {(app.isEmpty ? [] : app.scenes.sizes).map(({ name, vertices, faces }) => (
        <span key={name} class="status-size" title={`${name}: vertices / faces`}>
          {name} {count(vertices)} / {count(faces)}
        </span>
      ))}
      <span class={`lamp ${status}`} title={told[status]} />
    </footer>
  );
}
