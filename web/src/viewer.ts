/** A page of one surface, for notebooks and for files: what `henkei.io.html` puts into it. */

import "./view/view.css";
import { h, render } from "preact";
import { Panel } from "./view/panel.tsx";
import { sceneOf } from "./view/scene.ts";
import { View } from "./view/view.ts";
import { shareWheel } from "./view/wheel.ts";

declare global {
  interface Window {
    /** The bytes of what a page holds, by the id of its element. */
    unpacked?: (id: string) => Promise<ArrayBuffer>;
    /** For tests, and for the curious. */
    view?: View;
  }
}

/** Milliseconds after which a picture that is out of sight gives its graphics card back. */
const REST = 2000;

/** Milliseconds after which a page that is told nothing counts as out of sight. */
const PATIENCE = 500;

async function begin(): Promise<void> {
  const scene = sceneOf(await window.unpacked!("surface"));
  const place = document.createElement("main");
  place.className = "view";
  document.body.append(place);
  const view = new View(scene, place);
  const seen = await isSeen(place);
  view.start();
  if (!seen) view.stop();
  document.querySelector("#figures")?.remove();
  const controls = document.createElement("div");
  controls.className = "view-controls";
  place.append(controls);
  render(h(Panel, { view }), controls);
  shareWheel(place);
  restWhileUnseen(place, view);
  window.view = view;
}

/** Whether a place is on the screen. */
function isSeen(place: HTMLElement): Promise<boolean> {
  return new Promise((resolve) => {
    const watch = new IntersectionObserver(([entry]) => {
      watch.disconnect();
      resolve(entry!.isIntersecting);
    });
    watch.observe(place);
    window.setTimeout(resolve, PATIENCE, false);
  });
}

/** Draws only while the page is on the screen. */
function restWhileUnseen(place: HTMLElement, view: View): void {
  let waiting = 0;
  const watch = new IntersectionObserver(([entry]) => {
    window.clearTimeout(waiting);
    if (entry!.isIntersecting) view.start();
    else waiting = window.setTimeout(() => view.stop(), REST);
  });
  watch.observe(place);
}

begin().catch((error: unknown) => {
  console.error(error);
  const note = document.createElement("p");
  note.setAttribute("role", "alert");
  note.textContent = error instanceof Error ? error.message : String(error);
  document.querySelector(".view")?.remove();
  document.body.append(note);
});
