import { Component, type ComponentChildren } from "preact";
import { useEffect, useReducer } from "preact/hooks";
import { Button, Help, Note, Toasts } from "../ui/index.ts";
import type { App } from "./app.ts";
import { Banner, Busy, Locked } from "./busy.tsx";
import { Divider } from "./divider.tsx";
import { DropZone } from "./drop.tsx";
import { Shelf } from "./shelf.tsx";
import { help } from "./shortcuts.ts";
import { ToolBar, ViewBar } from "./stagebars.tsx";
import { StartPage } from "./start.tsx";
import { StatusLine } from "./statusline.tsx";
import { TopBar } from "./topbar.tsx";

/** Everything around the stage. */
export function Shell({ app }: { app: App }) {
  const [, redraw] = useReducer((turns: number, _: void) => turns + 1, 0);
  useEffect(() => app.subscribe(redraw), [app]);
  const starting = app.isEmpty || app.overlay === "start";
  return (
    <div class={`shell${starting ? " starting" : ""}`}>
      <TopBar app={app} />
      <div class={`working${app.working > 0 ? " on" : ""}`} aria-hidden="true" />
      <main>
        <div class="stage-place">
          <StagePlace app={app} />
          {!starting && <ToolBar app={app} />}
          {!starting && <ViewBar app={app} />}
          {starting && app.state && <StartPage app={app} />}
          {!app.state && <Waiting app={app} />}
          <Banner app={app} />
          <Busy app={app} />
          <Toasts toasts={app.toasts} onClose={(toast) => app.dismiss(toast)} />
        </div>
        {!starting && <Divider />}
        {!starting && <Panel app={app} />}
      </main>
      <StatusLine app={app} />
      <DropZone app={app} />
      {app.overlay === "help" && <Help parts={help(app)} onClose={() => app.show(null)} />}
    </div>
  );
}

/** Where the stage's own element is; it is made once, and moved in. */
class StagePlace extends Component<{ app: App }> {
  override shouldComponentUpdate() {
    return false;
  }
  override render({ app }: { app: App }) {
    return <div class="stage" ref={(place) => void place?.append(app.place)} />;
  }
}

function Panel({ app }: { app: App }) {
  const { tab, state } = app;
  const entry = state?.tabs[tab.name];
  return (
    <div class="panel" id="panel" role="tabpanel" aria-labelledby={`tab-${tab.name}`}>
      <Shelf app={app} />
      {entry && (
        <Guard key={tab.name} app={app} revision={state.revision}>
          {entry.view.problem && <Note>{entry.view.problem}</Note>}
          {entry.view.warnings?.map((warning) => (
            <Note key={warning}>{warning}</Note>
          ))}
          <tab.Panel state={entry.state} view={entry.view} studio={app} />
        </Guard>
      )}
    </div>
  );
}

type GuardProps = { app: App; revision: number; children: ComponentChildren };

/** Keeps a panel's mistake to the panel. */
class Guard extends Component<GuardProps, { broken: number | null }> {
  override state = { broken: null };
  override componentDidCatch(error: unknown) {
    this.setState({ broken: this.props.revision });
    this.props.app.failed(error);
  }
  override render({ revision, children }: GuardProps, { broken }: { broken: number | null }) {
    if (broken !== revision) return children;
    return (
      <Note level="error">
        This panel could not be drawn. Undo the last step, or try again.
        <Button label="Try again" onClick={() => this.setState({ broken: null })} />
      </Note>
    );
  }
}

function Waiting({ app }: { app: App }) {
  return (
    <div class="waiting">
      {app.status === "connecting" && (
        <>
          <span class="spinner" /> Connecting to the studio …
        </>
      )}
      {app.status === "connected" && (
        <>
          <span class="spinner" /> The studio is at work, and answers when that is done …
        </>
      )}
      {app.status === "locked" && <Locked />}
    </div>
  );
}
