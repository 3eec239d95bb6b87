import {
  Choice,
  Figures,
  MeshChoice,
  NumberField,
  Section,
  short,
  Toggle,
} from "../../ui/index.ts";
import { ByNumber, Pairs } from "./correspondence.tsx";
import { Morphs } from "./morphs.tsx";
import { Next } from "./next.tsx";
import { modeOf, page } from "./page.ts";
import {
  type CombineState,
  type CombineView,
  type Props,
  type SideName,
  sideNames,
} from "./types.ts";

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
      {view.snaps && (
        <NumberField
          label="Snap"
          unit="% of size"
          min={0}
          max={100}
          hint="How far points of the recipe may be from a vertex"
          value={100 * recipe.snap}
          onChange={(percent) => change({ snap: percent / 100 })}
        />
      )}
      <Toggle
        label="Carry attributes"
        hint="Normals, texture coordinates, colours and labels of both ride along"
        value={recipe.attributes}
        onChange={(attributes) => change({ attributes })}
      />
    </Section>
  );
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
