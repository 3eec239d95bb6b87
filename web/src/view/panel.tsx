/** The controls over the picture. */

import { useEffect, useReducer } from "preact/hooks";
import { IconButton } from "../ui/buttons.tsx";
import { Menu } from "../ui/menu.tsx";
import type { Slide } from "./scene.ts";
import type { View } from "./view.ts";

const SIDES = ["front", "back", "left", "right", "top", "bottom"] as const;

export function Panel({ view }: { view: View }) {
  const [, again] = useReducer((count: number) => count + 1, 0);
  useEffect(() => view.subscribe(() => again(0)), [view]);
  return (
    <>
      <div class="view-head">
        {view.scene.colourings.length > 0 && <Colours view={view} />}
        <output>{view.under}</output>
      </div>
      <Tools view={view} />
      {view.scene.slides.length > 0 && (
        <div class="view-slides" role="group" aria-label="Shape">
          {view.scene.slides.map((slide, which) => (
            <Slider key={which} view={view} slide={slide} which={which} />
          ))}
        </div>
      )}
    </>
  );
}

function Colours({ view }: { view: View }) {
  const { colourings } = view.scene;
  return (
    <select
      aria-label="Colours"
      value={view.shown ?? ""}
      onChange={({ currentTarget: { value } }) => view.show(value === "" ? null : Number(value))}
    >
      <option value="">no colours</option>
      {colourings.map(({ name }, k) => (
        <option key={k} value={k}>
          {name}
        </option>
      ))}
    </select>
  );
}

function Tools({ view }: { view: View }) {
  const viewport = () => view.stage?.viewports[0];
  const dark = view.theme === "dark";
  return (
    <div class="view-tools" role="toolbar" aria-label="View">
      <IconButton
        icon="edges"
        label="Edges"
        pressed={view.edges}
        onClick={() => view.setEdges(!view.edges)}
      />
      <IconButton
        icon={view.shading}
        label="Smooth shading"
        pressed={view.shading === "smooth"}
        onClick={() => view.setShading(view.shading === "smooth" ? "flat" : "smooth")}
      />
      <Menu
        label="View from"
        icon="view"
        bare
        align="right"
        items={SIDES.map((side) => ({
          label: side[0]!.toUpperCase() + side.slice(1),
          onSelect: () => viewport()?.view(side),
        }))}
      />
      <IconButton icon="frame" label="Fit" keys="F" onClick={() => viewport()?.frame()} />
      <IconButton
        icon={dark ? "sun" : "moon"}
        label={dark ? "Light" : "Dark"}
        onClick={() => view.setTheme(dark ? "light" : "dark")}
      />
      {document.fullscreenEnabled && (
        <button
          type="button"
          class="icon-button"
          aria-label="Full screen"
          title="Full screen"
          onClick={() => void toggleFullScreen()}
        >
          <svg class="icon" width={16} height={16} viewBox="0 0 16 16" aria-hidden="true">
            <path d="M9.5 2H14v4.5M14 2 9 7M6.5 14H2V9.5M2 14l5-5" />
          </svg>
        </button>
      )}
    </div>
  );
}

async function toggleFullScreen(): Promise<void> {
  if (document.fullscreenElement) await document.exitFullscreen();
  else await document.documentElement.requestFullscreen();
}

function Slider({ view, slide, which }: { view: View; slide: Slide; which: number }) {
  const { name, from: low, to: high, ends } = slide;
  const value = view.values[which]!;
  const plays = view.playing === which;
  const filled = `${(100 * (value - low)) / (high - low)}%`;
  return (
    <div class="view-slide">
      <IconButton
        icon={plays ? "pause" : "play"}
        label={`${plays ? "Pause" : "Play"} ${name}`}
        onClick={() => (plays ? view.pause() : view.play(which))}
      />
      <span>{ends ? ends[0] : name}</span>
      <input
        type="range"
        aria-label={name}
        min={low}
        max={high}
        step={(high - low) / 200}
        value={value}
        style={{ "--filled": filled }}
        onInput={({ currentTarget }) => {
          view.pause();
          view.slide(which, currentTarget.valueAsNumber);
        }}
        onDblClick={() => view.slide(which, slide.start)}
      />
      <span>{ends ? ends[1] : value.toFixed(1).replace("-", "\u2212")}</span>
    </div>
  );
}
