import { Button, Choice, Note, Section, Slider, Toggle } from "../../ui/index.ts";
import type { Studio } from "../tab.ts";
import { type DesignState, own, type Refinement } from "./state.ts";

type Props = { state: DesignState; studio: Studio };

const AXES = ["x", "y", "z"] as const;
const GAMMA = { min: 0.25, max: 16, logarithmic: true } as const;

/** A slider of a setting, live; the server is told before it begins to move. */
function settingSlider(studio: Studio, change: (value: number) => object) {
  return {
    onInput: (value: number) => {
      if (!own.sliding) studio.grab("design");
      own.sliding = true;
      studio.live("design", "change", change(value));
    },
    onCancel: () => {
      own.sliding = false;
      studio.drop();
    },
    onChange: (value: number) => {
      own.sliding = false;
      return studio.do("design", "change", change(value));
    },
  };
}

/** How far constraints reach, live. */
export function Smoothness({ state, studio }: Props) {
  const { gamma, axis_gamma: axes, axis_smoothing: smoothed } = state.recipe;
  const one = typeof gamma === "number" ? gamma : 2;
  return (
    <Section title="Smoothness" step={3}>
      {typeof gamma !== "number" && (
        <Note level="info">
          The recipe has a weight for each level.
          <Button
            label="Use one gamma"
            onClick={() => void studio.do("design", "change", { gamma: 2 })}
          />
        </Note>
      )}
      {typeof gamma === "number" && !axes && (
        <Slider
          label="Gamma"
          {...GAMMA}
          value={gamma}
          {...settingSlider(studio, (value) => ({ gamma: value }))}
          hint="Above 1 the surface is smoothed over, below 1 it keeps the facets of the cage"
        />
      )}
      {axes &&
        AXES.map((axis, k) => (
          <Slider
            key={axis}
            label={`Gamma ${axis}`}
            {...GAMMA}
            value={axes[k]!}
            {...settingSlider(studio, (value) => ({
              axis_gamma: axes.map((other, j) => (j === k ? value : other)),
            }))}
          />
        ))}
      <Toggle
        label="Each axis by itself"
        value={axes !== null}
        onChange={(on) =>
          studio.do("design", "change", { axis_gamma: on ? [one, one, one] : "off" })
        }
      />
      {(axes || smoothed.includes(false)) && (
        <div class="field">
          <span class="label">Smooth along</span>
          <span class="axes">
            {AXES.map((axis, k) => (
              <Toggle
                key={axis}
                label={axis}
                value={smoothed[k]!}
                onChange={(on) =>
                  studio.do("design", "change", {
                    axis_smoothing: smoothed.map((other, j) => (j === k ? on : other)),
                  })
                }
              />
            ))}
          </span>
        </div>
      )}
    </Section>
  );
}

const CUTS = [
  { value: "auto", label: "Auto", hint: "Triangles if the whole cage is of triangles" },
  { value: "triangles", label: "Triangles" },
  { value: "quads", label: "Quads" },
] as const;

const MEANINGS = [
  {
    value: "coarse",
    label: "Coarse part",
    hint: "For the coarse part of the shape: detail may add to it. Smooth",
  },
  {
    value: "points",
    label: "Very points",
    hint: "For the very points that they name, at all finer levels. Leaves tips",
  },
] as const;

/** What is seldom changed. */
export function More({ state, studio }: Props) {
  const { refinement, interpolating, steps } = state.recipe;
  return (
    <Section title="More settings" open={false}>
      <Slider
        label="Steps"
        min={0}
        max={100}
        step={1}
        value={steps}
        {...settingSlider(studio, (value) => ({ steps: value }))}
        hint="Of smoothing at each level; 30 are enough, more help little"
      />
      <Choice<Refinement>
        label="Faces into"
        value={refinement}
        options={CUTS}
        onChange={(next) => studio.do("design", "change", { refinement: next })}
      />
      <Choice<"coarse" | "points">
        label="Pins hold for"
        value={interpolating ? "points" : "coarse"}
        options={MEANINGS}
        onChange={(next) => studio.do("design", "change", { interpolating: next === "points" })}
      />
    </Section>
  );
}
