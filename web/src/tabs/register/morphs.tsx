import { useEffect, useReducer } from "preact/hooks";
import { Button, Buttons, Choice, NumberField, Section, Slider } from "../../ui/index.ts";
import type { Studio } from "../tab.ts";
import { page } from "./page.ts";
import type { Morphing, Props, Result } from "./types.ts";

const sweeps = ["top", "bottom", "left", "right", "front", "back"] as const;

/** The way from the source's form to the target's: its time, and how it runs. */
export function Morphs({ state, view, studio, result }: Props & { result: Result }) {
  const { morph } = state.recipe;
  const change = (part: Partial<Morphing>) =>
    studio.do("register", "change_morph", { morph: part });
  const prepared = result.turning !== null;
  return (
    <Section title="Morph">
      <Scrubber studio={studio} />
      <Choice
        label="Path"
        value={morph.path}
        options={[
          { value: "linear", label: "Straight", hint: "Each vertex on a straight line" },
          { value: "rotation", label: "Turning", hint: "Parts turn rather than shrink" },
        ]}
        onChange={(path) =>
          path === "rotation" && !prepared && view.turnable
            ? studio.do("register", "turn")
            : change({ path })
        }
      />
      {morph.path === "rotation" && !prepared && view.turnable && (
        <Buttons>
          <Button
            label="Prepare the turning path"
            hint="It is shown straight until then; exports turn all the same"
            onClick={() => void studio.do("register", "turn")}
          />
        </Buttons>
      )}
      <Choice
        label="Speed"
        value={morph.time}
        options={[
          { value: "linear", label: "Constant" },
          { value: "smoothstep", label: "Eased", hint: "At rest at both ends" },
        ]}
        onChange={(time) => change({ time })}
      />
      <Choice
        label="Changes first"
        as="select"
        value={morph.sweep ?? ""}
        options={[
          { value: "", label: "all at once" },
          ...sweeps.map((side) => ({ value: side, label: side })),
        ]}
        onChange={(side) => change({ sweep: side || null })}
      />
      <NumberField
        label="Duration"
        unit="s"
        min={0.1}
        max={600}
        step={0.5}
        value={morph.seconds}
        hint="Of one pass, also where it is exported"
        onChange={(seconds) => change({ seconds })}
      />
      <NumberField
        label="Frames"
        min={2}
        max={10000}
        step={1}
        value={morph.frames}
        hint="Shapes in one pass, where it is exported"
        onChange={(frames) => change({ frames: Math.round(frames) })}
      />
    </Section>
  );
}

/** Time, by slider or played. */
function Scrubber({ studio }: { studio: Studio }) {
  const { player } = page;
  const [, redraw] = useReducer((turns: number, _: void) => turns + 1, 0);
  useEffect(() => player.subscribe(redraw), [player]);
  return (
    <>
      <Slider
        label="Time"
        min={0}
        max={1}
        digits={3}
        value={player.time}
        hint="0 is the source's form, 1 the target's"
        onInput={(time) => {
          player.stop();
          player.seek(time);
        }}
        onChange={(time) => player.seek(time)}
      />
      <Buttons>
        <Button
          label={player.playing ? "Pause" : "Play"}
          icon={player.playing ? "pause" : "play"}
          keys="Space"
          onClick={() => player.toggle()}
        />
        <Button
          label="Keep shape"
          kind="quiet"
          hint="Open the shape at this time as a mesh, to go on with it in any tab"
          onClick={() => {
            const what = `at ${player.time}`;
            void studio.do("document", "keep", { tab: "register", what });
          }}
        />
      </Buttons>
    </>
  );
}
