import type { TabName } from "../state.ts";
import type { App } from "./app.ts";

/** Brings the stage to what the tab in front is to show, one scene at a time. */
export class Scenes {
  /** The tab that the viewports belong to. */
  shown: TabName | null = null;
  /** Of what is seen, for the status line. */
  sizes: Size[] = [];
  private wanted = false;
  private running = false;
  private leave: () => void = () => {};

  constructor(private readonly app: App) {}

  /** Soon, and again if it is asked for meanwhile. */
  async bring(): Promise<void> {
    this.wanted = true;
    if (this.running) return;
    this.running = true;
    while (this.wanted) {
      this.wanted = false;
      try {
        await this.scene();
      } catch (error) {
        this.app.failed(error);
      }
    }
    this.running = false;
  }

  private async scene(): Promise<void> {
    const { app } = this;
    const { tab, state } = app;
    const entry = state?.tabs[tab.name];
    if (!entry) return;
    if (this.shown !== tab.name) this.enter();
    await tab.scene(app, entry.state, entry.view);
    if (app.tab !== tab) return;
    app.moved.catchUp(tab.name, app.viewports);
    this.sizes = this.sizesNow();
    app.redraw();
  }

  private enter(): void {
    const { app } = this;
    const { tab, stage } = app;
    this.leave();
    stage.layout(tab.viewports, true);
    for (const viewport of stage.viewports) {
      viewport.clear();
      viewport.tool = app.tool.viewport;
    }
    this.shown = tab.name;
    const offs = tab.enter?.(app) ?? [];
    this.leave = () => {
      for (const off of offs) off();
      tab.leave?.(app);
    };
  }

  /** The surfaces that are seen, each blob once. */
  private sizesNow(): Size[] {
    const seen = new Map<string, Size>();
    for (const viewport of this.app.viewports)
      for (const key of viewport.keys) {
        const surface = viewport.surface(key)!;
        const source = this.app.blobs.source(surface.data);
        if (source && surface.styled.visible && !seen.has(source.id))
          seen.set(source.id, { name: key, ...source });
      }
    return [...seen.values()];
  }
}

type Size = { name: string; vertices: number; faces: number };
