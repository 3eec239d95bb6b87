import {
  Button,
  Buttons,
  Choice,
  Figures,
  Hint,
  List,
  MeshChoice,
  type Row,
  Section,
  Slider,
  Toggle,
  type Vector,
  VectorField,
  count,
  counted,
} from "../../ui/index.ts";
import type { Studio } from "../tab.ts";
import { More, Smoothness } from "./settings.tsx";
import {
  choose,
  colourOf,
  type DesignState,
  type DesignView,
  levelAt,
  meaning,
  own,
  type Part,
  remove,
  workAt,
} from "./state.ts";

type Props = { state: DesignState; view: DesignView; studio: Studio };

const DOT = { display: "inline-block", width: "9px", height: "9px", borderRadius: "50%" };

/** All controls of the tab. */
export function Panel({ state, view, studio }: Props) {
  const meshes = studio.state?.meshes ?? [];
  return (
    <>
      <Section title="Cage" step={1} done={view.shown !== undefined}>
        <MeshChoice
          label="Mesh"
          meshes={meshes}
          value={state.cage}
          onChange={(mesh) => studio.do("design", "use", { slot: "cage", mesh })}
          hint="A coarse mesh of some dozens of faces; the smooth surface is made from it"
        />
        {view.next && <Hint>{view.next}</Hint>}
        {state.cage && (
          <Toggle
            label="Show the cage"
            value={own.cage}
            onChange={(on) => {
              own.cage = on;
              studio.changed();
            }}
          />
        )}
      </Section>
      {view.shown !== undefined && (
        <>
          <Levels state={state} view={view} studio={studio} />
          <Smoothness state={state} studio={studio} />
          <Constraints state={state} view={view} studio={studio} />
          <Held state={state} view={view} studio={studio} />
          <More state={state} studio={studio} />
          <Quality view={view} studio={studio} />
        </>
      )}
    </>
  );
}

function Levels({ state, view, studio }: Props) {
  const { levels } = state.recipe;
  const level = levelAt(state, view);
  const size = view.levels[level];
  return (
    <Section title="Levels" step={2}>
      <Choice
        label="Work at level"
        as="segments"
        value={String(level)}
        options={view.levels.map((_, k) => ({
          value: String(k),
          label: String(k),
          hint: meaning(k, levels),
          disabled: state.stroke !== null && k !== level,
        }))}
        onChange={(chosen) => workAt(studio, Number(chosen))}
        hint="Clicks mean vertices of this level ([ and ])"
      />
      <Hint>
        <span class="dot" style={{ ...DOT, background: colourOf(level) }} /> Level {level},{" "}
        {meaning(level, levels)}.
        {size && ` ${counted(size.vertices, "vertex", "vertices")} to pin.`}
      </Hint>
      <Slider
        label="Level shown"
        min={0}
        max={levels}
        step={1}
        value={view.shown ?? 0}
        onChange={(shown) => {
          own.level = Math.min(own.level, shown);
          return studio.do("design", "show", { level: shown });
        }}
        hint="The surface as if this were the last level"
      />
      <Slider
        label="Levels"
        min={Math.min(2, levels)}
        max={Math.max(6, levels)}
        step={1}
        value={levels}
        onChange={(next) => studio.do("design", "set_levels", { levels: next })}
        hint={`How often the cage is refined; the finest has ${count(view.levels.at(-1)!.faces)} faces`}
      />
    </Section>
  );
}

function Constraints({ state, view, studio }: Props) {
  const fighting = new Set((view.conflicts ?? []).flat());
  return (
    <Section title="Pins and curves" step={4} done={view.parts.length > 0}>
      {state.stroke && (
        <Buttons>
          <Button
            label="End curve"
            kind="primary"
            keys="Enter"
            onClick={() => void studio.do("design", "end_curve")}
          />
          <Button
            label="Leave it"
            keys="Escape"
            onClick={() => void studio.do("design", "drop_curve")}
          />
        </Buttons>
      )}
      {!state.stroke && (
        <Buttons>
          <Button label="Pin" icon="pin" keys="P" onClick={() => studio.take("pin")} />
          <Button label="Curve" icon="curve" keys="C" onClick={() => studio.take("curve")} />
        </Buttons>
      )}
      <List
        label="Pins and curves"
        rows={view.parts.map((part): Row => {
          const selected = part.name === own.chosen;
          return {
            id: part.name,
            name: part.name,
            colour: colourOf(part.level),
            detail: part.to || part.kind === "derivatives" ? `level ${part.level}` : "not shown",
            selected,
            bad: fighting.has(part.name),
            hint: fighting.has(part.name) ? "It contradicts others; they are averaged" : undefined,
            below: selected && <Chosen part={part} studio={studio} />,
          };
        })}
        onSelect={(name) => choose(studio, name === own.chosen ? null : name)}
        onRename={async (name, to) => {
          if (await studio.do("design", "rename", { name, to })) choose(studio, to);
        }}
        onRemove={(name) => void remove(studio, name)}
        empty="None yet: the surface follows the cage alone."
      />
    </Section>
  );
}

/** What can be said of the pin or curve in hand. */
function Chosen({ part, studio }: { part: Part; studio: Studio }) {
  if (!part.to) {
    return part.kind === "derivatives" ? (
      <Hint>The way that the surface leaves a point; it is changed in the recipe.</Hint>
    ) : (
      <Button label={`Show level ${part.level}`} onClick={() => void workAt(studio, part.level)} />
    );
  }
  if (part.kind === "pins") {
    const { name } = part;
    return (
      <VectorField
        label="Goes to"
        value={part.to as Vector}
        onInput={(to) => studio.live("design", "move_pin", { name, to })}
        onCancel={() => studio.drop()}
        onChange={(to) => studio.do("design", "move_pin", { name, to })}
      />
    );
  }
  return <ChosenCurve name={part.name} studio={studio} />;
}

function ChosenCurve({ name, studio }: { name: string; studio: Studio }) {
  const one = own.point === null ? {} : { index: own.point, reach: own.reach };
  const moved = (by: Vector) => ({ name, by, ...one });
  return (
    <>
      <VectorField
        label="Move by"
        value={[0, 0, 0]}
        onInput={(by) => studio.live("design", "move_curve", moved(by))}
        onCancel={() => studio.drop()}
        onChange={(by) => studio.do("design", "move_curve", moved(by))}
      />
      <Slider
        label="Others follow"
        min={0}
        max={1}
        value={own.reach}
        onChange={(reach) => {
          own.reach = reach;
          studio.changed();
        }}
        hint="When a point of the line is dragged: how far along the line others come with it"
      />
      {own.point !== null && <Hint>Point {own.point + 1} of the line is in hand.</Hint>}
      {own.point !== null && (
        <Button
          label="Whole line"
          onClick={() => choose(studio, name)}
          hint="Move all its points"
        />
      )}
    </>
  );
}

function Held({ view, studio }: Props) {
  const all = view.levels[0]!.vertices;
  const hold = (held: boolean) => void studio.do("design", "hold", { held });
  return (
    <Section
      title="Held by the cage"
      open={false}
      aside={`${count(all - view.let_go)} of ${count(all)}`}
    >
      <Hint>
        The cage holds the surface by its vertices. Let those beside a pull go where it dents its
        surroundings.
      </Hint>
      <Buttons>
        <Button label="Choose" icon="pick" keys="H" onClick={() => studio.take("hold")} />
        <Button label="Hold all" disabled={view.let_go === 0} onClick={() => hold(true)} />
        <Button label="Let all go" disabled={view.let_go === all} onClick={() => hold(false)} />
      </Buttons>
    </Section>
  );
}

function Quality({ view, studio }: { view: DesignView; studio: Studio }) {
  return (
    <Section title="Figures">
      <Figures label="Figures" figures={view.figures} />
      <Toggle
        label="Colour by curvature"
        value={own.curvature}
        onChange={(on) => {
          own.curvature = on;
          studio.changed();
        }}
        hint="Red bulges outward, blue inward: bands and spots are where it is not smooth"
      />
    </Section>
  );
}
