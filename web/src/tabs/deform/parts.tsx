import {
  Button,
  Buttons,
  Choice,
  count,
  Hint,
  List,
  type Row,
  Section,
  short,
  Slider,
  useHeld,
  VectorField,
} from "../../ui/index.ts";
import type { Studio } from "../tab.ts";
import { hover } from "./found.tsx";
import { chosen, choose, memory, unchoose } from "./memory.ts";
import { moveHandle } from "./moving.ts";
import { movePin } from "./pinning.ts";
import {
  colours,
  type DeformView,
  type FeaturePart,
  type HandlePart,
  isRegion,
  type Keep,
  type Kind,
  type Move,
  type Part,
  type PinPart,
} from "./types.ts";

const titles: Record<Kind, string> = {
  fixed: "stays",
  handles: "is moved",
  features: "keeps its shape",
  pins: "is pinned",
};

/** What stays, what moves and what keeps its shape; the chosen one with its controls. */
export function Parts({ view, studio }: { view: DeformView; studio: Studio }) {
  const parts = view.parts ?? [];
  const look = chosen(view);
  const idOf = (part: Part) => `${part.kind} ${part.name}`;
  const byId = (id: string) => parts.find((part) => idOf(part) === id)!;
  return (
    <Section title="Parts" aside={parts.length > 0 && <span class="detail">{parts.length}</span>}>
      <div style={{ maxHeight: "14em", overflowY: "auto", paddingRight: "10px" }}>
        <List
          label="Parts"
          empty="Nothing yet. What is fixed stays, a handle is moved, a feature keeps its shape."
          rows={parts.map((part): Row => ({
            id: idOf(part),
            name: part.name,
            colour: colours[part.kind],
            detail: detail(part),
            hint: `${part.name} ${titles[part.kind]}`,
            selected: part === look,
          }))}
          onSelect={(id) => {
            const part = byId(id);
            if (part === look) unchoose(studio);
            else choose(studio, part.kind, part.name);
          }}
          onRename={async (id, to) => {
            const { kind, name } = byId(id);
            const done = await studio.do("deform", "rename", { kind, name, to });
            if (done && memory.part?.kind === kind && memory.part.name === name)
              memory.part = { kind, name: to };
            studio.changed();
          }}
          onRemove={(id) => {
            const { kind, name } = byId(id);
            void studio.do("deform", "remove", { kind, name });
          }}
          onHover={(id) => {
            const part = id === null ? undefined : byId(id);
            hover(studio, part && isRegion(part) ? `part ${part.name}` : null);
          }}
        />
      </div>
      {look && (
        <div role="group" aria-label={look.name} style={{ display: "grid", gap: "6px" }}>
          <Controls key={`${look.kind} ${look.name}`} part={look} studio={studio} />
        </div>
      )}
    </Section>
  );
}

function detail(part: Part): string {
  if (part.kind === "pins") return part.vertex === null ? "" : `vertex ${count(part.vertex)}`;
  if (part.kind === "features" && part.radius !== null) return `radius ${short(part.radius)}`;
  if (part.kind === "features" && part.scale !== 1) return `× ${short(part.scale, 3)}`;
  return count(part.count);
}

function Controls({ part, studio }: { part: Part; studio: Studio }) {
  if (part.kind === "handles") return <HandleControls part={part} studio={studio} />;
  if (part.kind === "features") return <FeatureControls part={part} studio={studio} />;
  if (part.kind === "pins") return <PinControls pin={part} studio={studio} />;
  return <Hint>{count(part.count)} vertices stay where they are.</Hint>;
}

const atRest: Move = { translation: [0, 0, 0], rotation: [0, 0, 0], scale: 1 };

function HandleControls({ part, studio }: { part: HandlePart; studio: Studio }) {
  const { name } = part;
  const held = useHeld(part.move); // the next change may come before this one is answered
  const now = memory.dragged ?? held.shown;
  const tried = (change: Partial<Move>) =>
    studio.live("deform", "move_handle", { name, move: { ...held.shown, ...change } });
  const done = (change: Partial<Move>) => {
    const move = { ...held.shown, ...change };
    held.hold(move);
    const answer = moveHandle(studio, name, move);
    held.settle(answer);
    return answer;
  };
  const moved = JSON.stringify(part.move) !== JSON.stringify(atRest);
  return (
    <>
      <VectorField
        label="Move"
        hint="From rest, in the unit of the mesh"
        value={now.translation}
        onInput={(translation) => tried({ translation })}
        onCancel={() => studio.drop()}
        onChange={(translation) => done({ translation })}
      />
      <VectorField
        label="Turn"
        unit="°"
        hint="Degrees about x, y and z as one rotation vector: its direction is the axis, its length the angle, which may be more than a full turn"
        value={now.rotation}
        step={1}
        onInput={(rotation) => tried({ rotation })}
        onCancel={() => studio.drop()}
        onChange={(rotation) => done({ rotation })}
      />
      <Slider
        label="Size"
        hint="Factor of the handle's size; the surface around follows"
        value={now.scale}
        min={0.5}
        max={2}
        logarithmic
        onInput={(scale) => tried({ scale })}
        onCancel={() => studio.drop()}
        onChange={(scale) => done({ scale })}
      />
      {moved && (
        <Buttons>
          <Button label="Back to rest" kind="quiet" onClick={() => void done(atRest)} />
        </Buttons>
      )}
    </>
  );
}

const keeps: { value: Keep; label: string }[] = [
  { value: "rigid", label: "All of its shape" },
  { value: "circle", label: "Its circle; sets the radius" },
  { value: "plane", label: "Its plane" },
  { value: "line", label: "Its straight line" },
];

async function setFeature(studio: Studio, feature: object): Promise<void> {
  if (!(await studio.do("deform", "set_feature", feature))) studio.drop();
}

function FeatureControls({ part, studio }: { part: FeaturePart; studio: Studio }) {
  const { name, rest_radius: rest } = part;
  const held = useHeld({ keep: part.keep, scale: part.scale, radius: part.radius });
  const { keep, scale, radius } = held.shown;
  const now = { name, keep, scale, radius };
  const tried = (change: object) => studio.live("deform", "set_feature", { ...now, ...change });
  const done = (change: Partial<typeof held.shown>) => {
    const next = { keep, scale, radius, ...change };
    held.hold(next);
    const answer = setFeature(studio, { name, ...next });
    held.settle(answer);
    return answer;
  };
  return (
    <>
      <Choice
        label="Keeps"
        as="select"
        value={keep}
        options={keeps}
        onChange={(next) => done({ keep: next, radius: next === "circle" ? radius : null })}
      />
      <Slider
        label="Size"
        hint={
          radius === null
            ? "Factor of its size"
            : "Factor along its axis only, as the radius is given"
        }
        value={scale}
        min={0.5}
        max={2}
        logarithmic
        onInput={(next) => tried({ scale: next })}
        onCancel={() => studio.drop()}
        onChange={(next) => done({ scale: next })}
      />
      {rest !== null && (
        <Slider
          label="Radius"
          hint={`At rest ${short(rest)}`}
          value={radius ?? scale * rest}
          min={rest / 2}
          max={rest * 2}
          logarithmic
          onInput={(next) => tried({ radius: next })}
          onCancel={() => studio.drop()}
          onChange={(next) => done({ radius: next })}
        />
      )}
      {(scale !== 1 || radius !== null) && (
        <Buttons>
          <Button
            label={rest === null ? "Size as at rest" : `Radius as at rest, ${short(rest)}`}
            kind="quiet"
            onClick={() => void done({ scale: 1, radius: null })}
          />
        </Buttons>
      )}
    </>
  );
}

function PinControls({ pin, studio }: { pin: PinPart; studio: Studio }) {
  const { name } = pin;
  return (
    <VectorField
      label="At"
      digits={5}
      hint="Where the point of the surface goes; or drag it on the picture"
      value={pin.to}
      onInput={(to) => studio.live("deform", "move_pin", { name, to })}
      onCancel={() => studio.drop()}
      onChange={(to) => movePin(studio, name, to)}
    />
  );
}
