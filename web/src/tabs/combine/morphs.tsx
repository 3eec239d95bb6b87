import { useEffect, useReducer } from "preact/hooks";
import { Button, Buttons, Choice, Note, NumberField, Section, Slider } from "../../ui/index.ts";
import type { Studio } from "../tab.ts";
import { page } from "./page.ts";
import type { CombineView, Morphing, Props, Result } from "./types.ts";

const sweeps = ["top", "bottom", "left", "right", "front", "back"] as const;

/** How the morph runs, and its time. */
export function Morphs({ state, view, studio, result }: Props & { result: Result }) {
  const { morph } = state.recipe;
  const change = (part: Partial<Morphing>) => studio.do("combine", "change_morph", { morph: part });
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
          path === "rotation" && !result.turning ? studio.do("combine", "turn") : change({ path })
        }
      />
      {morph.path === "rotation" && !result.turning && <Turning view={view} studio={studio} />}
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
      <Choice
        label="Colour by"
        as="select"
        value={result.colours.some((one) => one.title === page.colour) ? page.colour : ""}
        options={[
          { value: "", label: "nothing" },
          ...result.colours.map(({ title }) => ({ value: title, label: title })),
        ]}
        onChange={(colour) => page.set({ colour })}
      />
    </Section>
  );
}

function Turning({ view, studio }: { view: CombineView; studio: Studio }) {
  return (
    <Note level="info">
      The turning path is not prepared, so the straight one is shown. Exports turn all the same.
      {view.turnable && (
        <Buttons>
          <Button label="Prepare it" onClick={() => void studio.do("combine", "turn")} />
        </Buttons>
      )}
    </Note>
  );
}

/** Time, by slider or played. */
function Scrubber({ studio }: { studio: Studio }) {
  const { player } = page;
  const [, redraw] = useReducer((turns: number, _: void) => turns + 1, 0);
  useEffect(() => player.subscribe(redraw), [player]);
  const look = () => page.mode === "morph" || page.show("morph");
  return (
    <>
      <Slider
        label="Time"
        min={0}
        max={1}
        digits={3}
        value={player.time}
        hint="0 is a, 1 is b"
        onInput={(time) => {
          player.stop();
          look();
          player.seek(time);
        }}
        onChange={(time) => player.seek(time)}
      />
      <Buttons>
        <Button
          label={player.playing ? "Pause" : "Play"}
          icon={player.playing ? "pause" : "play"}
          keys="Space"
          onClick={() => {
            look();
            player.toggle();
          }}
        />
        <Button
          label="Keep shape"
          kind="quiet"
          hint="Open the shape at this time as a mesh, to go on with it in any tab"
          onClick={() => {
            const what = `at ${player.time}`;
            void studio.do("document", "keep", { tab: "combine", what });
          }}
        />
      </Buttons>
    </>
  );
}
