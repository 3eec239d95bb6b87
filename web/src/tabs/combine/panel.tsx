import { useEffect, useReducer, useState } from "preact/hooks";
import {
  Button,
  Buttons,
  Choice,
  Figures,
  Hint,
  List,
  MeshChoice,
  Note,
  NumberField,
  Progress,
  Section,
  short,
  Slider,
  Toggle,
} from "../../ui/index.ts";
import { Pairing, pairColour } from "../shared/pairing.ts";
import type { Studio } from "../tab.ts";
import { labelOf, modeOf, page } from "./page.ts";
import {
  type CombineState,
  type CombineView,
  type Fix,
  type Kind,
  type Morphing,
  type Result,
  type SideName,
  type Trouble,
  sideNames,
} from "./types.ts";

type Props = { state: CombineState; view: CombineView; studio: Studio };

/** What to do next is at the top; below it, what belongs to what is looked at. */
export function Panel(props: Props) {
  const { state, view } = props;
  const mode = modeOf(view);
  const chosen = state.a !== null && state.b !== null && view.sides !== undefined;
  return (
    <>
      <Next {...props} />
      {view.result && <Looking view={view} />}
      {mode === "sides" && <Surfaces {...props} />}
      {mode === "sides" && chosen && (
        <>
          <Pairs kind="pairs" {...props} />
          <Pairs kind="landmarks" {...props} />
          <ByNumber {...props} />
          <Options {...props} />
        </>
      )}
      {mode === "morph" && <Morphs {...props} result={view.result!} />}
      {mode !== "sides" && (
        <Section title="Figures">
          <Figures label="Figures of the combined mesh" figures={view.result!.figures} />
        </Section>
      )}
    </>
  );
}

/** What to do now, what stands in the way, and the one button. */
function Next({ state, view, studio }: Props) {
  const job = studio.jobs.find((one) => one.tab === "combine" && one.title === "Combine");
  const again = view.result && !view.result.current;
  return (
    <div class="section section-body">
      {view.next && <Note level="info">{view.next}</Note>}
      {view.trouble && <TroubleNote trouble={view.trouble} studio={studio} />}
      {job ? (
        <Progress
          title="Combining"
          message={job.message}
          fraction={job.fraction ?? null}
          onCancel={() => studio.cancel(job.job)}
        />
      ) : (
        state.a !== null &&
        state.b !== null && (
          <Button
            label={again ? "Combine again" : "Combine"}
            kind={view.result?.current ? "plain" : "primary"}
            keys="Enter"
            wide
            disabled={!view.ready}
            hint={view.trouble?.message ?? "One mesh with both forms"}
            onClick={() => void page.combine()}
          />
        )
      )}
    </div>
  );
}

function Looking({ view }: { view: CombineView }) {
  const mode = modeOf(view);
  return (
    <Section title="Look at">
      <Choice
        label="Show"
        as="segments"
        value={mode}
        options={[
          { value: "sides", label: "Both", hint: "Both meshes, side by side (S)" },
          { value: "plane", label: "Flattened", hint: "In the common plane (P)" },
          { value: "morph", label: "Morph", hint: "From one to the other (M)" },
        ]}
        onChange={(next) => page.show(next)}
      />
      {mode === "sides" && (
        <Toggle
          label="Combined mesh"
          hint="Show the edges of the combined mesh on both"
          value={page.whole}
          onChange={(whole) => page.set({ whole })}
        />
      )}
      {mode === "plane" && (
        <Toggle
          label="Overlay"
          hint="One over the other in one large picture; the wheel enlarges it"
          value={page.overlaid}
          onChange={(overlaid) => page.set({ overlaid })}
        />
      )}
      {mode !== "sides" && (
        <Toggle
          label="Mark pairs"
          value={page.marked}
          onChange={(marked) => page.set({ marked })}
        />
      )}
    </Section>
  );
}

function Surfaces({ state, studio }: Props) {
  const meshes = studio.state?.meshes ?? [];
  return (
    <Section title="Surfaces">
      {sideNames.map((slot) => (
        <MeshChoice
          key={slot}
          label={slot === "a" ? "a, left" : "b, right"}
          meshes={meshes}
          value={state[slot]}
          onChange={(mesh) => studio.do("combine", "use", { slot, mesh })}
        />
      ))}
      <Toggle
        label="Link cameras"
        hint="Both are seen from the same side"
        value={page.linked}
        onChange={(linked) => page.set({ linked })}
      />
    </Section>
  );
}

const titles: Record<Kind, string> = { pairs: "Boundary pairs", landmarks: "Landmarks inside" };
const names: Record<Kind, string> = { pairs: "Pair", landmarks: "Landmark" };
const empty: Record<Kind, string> = {
  pairs: "Click along the boundaries: left, then right. At least three, in any order.",
  landmarks: "Where features inside shall meet: eyes, noses, corners. Not needed.",
};

function Pairs({ kind, state, view, studio }: Props & { kind: Kind }) {
  const pairs = view[kind] ?? [];
  const { pairing } = page;
  const proposed = kind === "pairs" && state.recipe.pairs === "auto";
  return (
    <Section title={titles[kind]} aside={pairs.length || undefined}>
      {proposed && <Hint>Proposed by shape: look, and drag what is not right.</Hint>}
      <List
        label={titles[kind]}
        empty={empty[kind]}
        rows={pairs.map(({ a, b }, index) => ({
          id: Pairing.idOf(kind, index),
          name: `${names[kind]} ${labelOf(kind, index)}`,
          colour: pairColour(index),
          detail: `${a} – ${b}`,
          hint: `Vertex ${a} of a, vertex ${b} of b`,
          selected: pairing.selected === Pairing.idOf(kind, index),
        }))}
        onSelect={(id) => pairing.select(pairing.selected === id ? null : id)}
        onRemove={(id) => {
          const index = Number(id.split(" ")[1]);
          void studio.do("combine", "remove_pair", { kind, index });
        }}
      />
      <Buttons>
        {kind === "pairs" && (
          <Button
            label="Propose"
            hint="Find boundary pairs by shape, in place of these"
            disabled={proposed}
            onClick={() => void studio.do("combine", "propose")}
          />
        )}
        <Button
          label={`Clear ${kind}`}
          kind="quiet"
          hint="Take all away, to click them anew"
          disabled={pairs.length === 0}
          onClick={() => {
            void studio.do("combine", "clear", { kind });
            studio.take(kind);
          }}
        />
      </Buttons>
    </Section>
  );
}

/** Pairs without the mouse. */
function ByNumber({ studio }: { studio: Studio }) {
  const [kind, setKind] = useState<Kind>("pairs");
  const [pair, setPair] = useState({ a: 0, b: 0 });
  return (
    <Section title="Add by vertex number" open={false}>
      <Choice<Kind>
        label="Kind"
        value={kind}
        options={[
          { value: "pairs", label: "Boundary" },
          { value: "landmarks", label: "Inside" },
        ]}
        onChange={setKind}
      />
      {sideNames.map((side) => (
        <NumberField
          key={side}
          label={`Vertex of ${side}`}
          value={pair[side]}
          min={0}
          step={1}
          digits={12}
          onChange={(vertex) => setPair({ ...pair, [side]: Math.round(vertex) })}
        />
      ))}
      <Buttons>
        <Button
          label="Add"
          icon="plus"
          onClick={() => void studio.do("combine", "add_pair", { kind, ...pair })}
        />
      </Buttons>
    </Section>
  );
}

const fixes: Record<Fix, string> = {
  fill_holes: "Fill holes",
  flip_b: "Flip b",
  propose: "Propose by shape",
  weld: "Weld duplicate vertices",
  oriented: "Turn faces to one side",
  largest_component: "Keep the largest piece",
  without_degenerate_faces: "Remove degenerate faces",
};

function Options({ state, view, studio }: Props) {
  const { recipe } = state;
  const change = (options: object) => studio.do("combine", "change", { options });
  return (
    <Section title="Options" open={false}>
      <Toggle
        label="Fill holes"
        hint="Close all boundary loops but the one that is matched"
        value={recipe.fill_holes}
        onChange={(fill_holes) => change({ fill_holes })}
      />
      {recipe.fill_holes && (
        <>
          <Toggle
            label="Leave fill out"
            hint="What lies in filled holes is not in the result"
            value={recipe.drop_fill}
            onChange={(drop_fill) => change({ drop_fill })}
          />
          {sideNames.map((side) => (
            <OuterLoop key={side} side={side} state={state} view={view} change={change} />
          ))}
        </>
      )}
      <Toggle
        label="Flip b"
        hint="Turn b inside out first, where the boundaries run in opposite directions"
        value={recipe.flip_b}
        onChange={(flip_b) => change({ flip_b })}
      />
      <Toggle
        label="Align b to a"
        hint="Move, turn and scale b onto a, so that only the form changes"
        value={recipe.align}
        onChange={(align) => change({ align })}
      />
      <Toggle
        label="Carry attributes"
        hint="Normals, texture coordinates, colours and labels of both ride along"
        value={recipe.attributes}
        onChange={(attributes) => change({ attributes })}
      />
    </Section>
  );
}

function TroubleNote({ trouble, studio }: { trouble: Trouble; studio: Studio }) {
  return (
    <Note>
      {trouble.message}
      {trouble.fixes.map((fix) => (
        <Buttons key={fix}>
          <Button label={fixes[fix]} onClick={() => void help(studio, fix, trouble.side)} />
        </Buttons>
      ))}
    </Note>
  );
}

async function help(studio: Studio, fix: Fix, side: SideName | ""): Promise<void> {
  if (fix === "propose") await studio.do("combine", "propose");
  else if (fix === "fill_holes" || fix === "flip_b")
    await studio.do("combine", "change", { options: { [fix]: true } });
  else if (await studio.do("document", "keep", { tab: "combine", what: `${fix} ${side}` })) {
    const mesh = studio.state!.meshes.at(-1)!.id;
    await studio.do("combine", "use", { slot: side, mesh });
  }
}

type OuterProps = {
  side: SideName;
  state: CombineState;
  view: CombineView;
  change(options: object): Promise<boolean>;
};

/** Which loop stays open, where there are several. */
function OuterLoop({ side, state, view, change }: OuterProps) {
  const { loops } = view.sides![side];
  if (loops.length < 2) return null;
  const { outer } = state.recipe;
  const k = side === "a" ? 0 : 1;
  const open = loops.find((loop) => loop.outer);
  return (
    <Choice
      label={`Open in ${side}`}
      as="select"
      hint="The boundary loop that is matched; the others are filled"
      value={outer[k] === null ? "" : String(open?.vertex)}
      options={[
        { value: "", label: "the longest loop" },
        ...loops.map((loop) => ({
          value: String(loop.vertex),
          label: `loop at vertex ${loop.vertex}, ${short(loop.length, 4)} long`,
        })),
      ]}
      onChange={(chosen) => {
        const next = [...outer];
        next[k] = chosen === "" ? null : Number(chosen);
        return change({ outer: next });
      }}
    />
  );
}

const sweeps = ["top", "bottom", "left", "right", "front", "back"] as const;

function Morphs({ state, view, studio, result }: Props & { result: Result }) {
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
