/** The page of henkei studio. */

import { h, render } from "preact";
import { comeBack, hideToken } from "./address.ts";
import { App } from "./shell/app.ts";
import { Shell } from "./shell/shell.tsx";
import { listenToKeys } from "./shell/shortcuts.ts";
import { stats } from "./stats.ts";
import { Stage } from "./viewer/index.ts";

declare global {
  interface Window {
    /** For tests, and for the curious. */
    henkei?: { studio: App; stage: Stage; stats: typeof stats };
  }
}

/** Says in place of the page why there is none. */
function instead(text: string): void {
  const note = document.createElement("p");
  note.className = "instead";
  note.setAttribute("role", "alert");
  note.textContent = text;
  document.body.replaceChildren(note);
}

function begin(): void {
  if (!document.createElement("canvas").getContext("webgl2"))
    return instead(
      "This browser offers no WebGL 2, which the studio draws with. Turn on hardware acceleration in the browser's settings, or open this address in a current Firefox, Chrome, Edge or Safari.",
    );
  const place = document.createElement("div");
  place.className = "stage-canvas";
  document.body.append(place); // measured by the stage
  const stage = new Stage(place);
  const app = new App(stage, place);
  window.henkei = { studio: app, stage, stats };
  addEventListener("error", (event) => {
    if (event.error) app.failed(event.error); // others are of extensions, and of layout loops
  });
  addEventListener("unhandledrejection", (event) => app.failed(event.reason));
  listenToKeys(app);
  hideToken();
  render(h(Shell, { app }), document.querySelector("#page")!);
}

try {
  if (document.querySelector("#page")) begin();
  else comeBack();
} catch (error) {
  console.error(error);
  instead(`The studio could not begin: ${error}. Load the page again, or use another browser.`);
}
