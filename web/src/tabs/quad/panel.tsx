import {
  Button,
  Buttons,
  Choice,
  counted,
  Figures,
  Hint,
  Note,
  Section,
  Toggle,
} from "../../ui/index.ts";
import type { Studio } from "../tab.ts";
import { page, type Sight } from "./page.ts";
import type { QuadState, QuadView, Result } from "./types.ts";
import { Edges, More, Size } from "./wishes.tsx";

type Props = { state: QuadState; view: QuadView; studio: Studio };

/** What is wished first, then the button, then what came of it. */
export function Panel(props: Props) {
  const { state, view } = props;
  if (state.mesh === null)
    return (
      <div class="section section-body">
        <Note level="info">{view.next}</Note>
      </div>
    );
  return (
    <>
      <Size {...props} />
      <Edges {...props} />
      <More {...props} />
      <Make {...props} />
      {view.result && <Quads {...props} result={view.result} />}
      <Cage {...props} />
    </>
  );
}

// The button

function Make({ view }: Props) {
  const job = page.job("quads");
  const again = view.result && !view.result.current;
  return (
    <div class="section section-body">
      {view.trouble && <Note>{view.trouble}</Note>}
      {view.next && <Note level={again ? "warning" : "info"}>{view.next}</Note>}
      <Button
        label={again ? "Make quads again" : "Make quads"}
        kind="primary"
        wide
        busy={job !== undefined}
        keys="Enter"
        disabled={view.trouble !== undefined}
        onClick={() => void page.make("quads")}
      />
    </div>
  );
}

// What came of it

const sights: { value: Sight; label: string; hint: string }[] = [
  { value: "quads", label: "Quads", hint: "Q" },
  { value: "quality", label: "Quality", hint: "How well each quad is shaped (W)" },
  { value: "patches", label: "Patches", hint: "Which patch each quad is from (P)" },
  { value: "input", label: "Input", hint: "What they were made of (I); hold C to compare" },
];

function Quads({ view, studio, result }: Props & { result: Result }) {
  const { irregular, arcs, features } = page.shown;
  const sight = page.sight(view);
  return (
    <Section title="Quads" aside={result.current ? undefined : "outdated"}>
      <Choice
        label="Show"
        value={sight}
        as="segments"
        options={sights}
        onChange={(next) => page.show(next)}
      />
      <Toggle
        label="Irregular vertices"
        value={irregular}
        onChange={(on) => page.set({ irregular: on })}
        hint="V"
      />
      <Toggle
        label="Patch boundaries"
        value={arcs || sight === "patches"}
        disabled={sight === "patches"}
        onChange={(on) => page.set({ arcs: on })}
        hint="L"
      />
      <Toggle
        label="Creases and boundaries"
        value={features}
        onChange={(on) => page.set({ features: on })}
        hint="G"
      />
      {result.warnings.map((warning) => (
        <Note key={warning}>{warning}</Note>
      ))}
      <Figures label="Figures of the quads" figures={result.figures} />
      <Buttons>
        <Button
          label="Use as mesh"
          icon="mesh"
          hint="Puts them among the open meshes, so that other tabs can take them"
          onClick={() => void keep(studio, view, "quads")}
        />
      </Buttons>
    </Section>
  );
}

function Cage({ state, view, studio }: Props) {
  const job = page.job("cage");
  const { cage } = state;
  return (
    <Section title="Cage" open={cage !== null}>
      <Hint>
        {cage
          ? `${counted(cage.faces, "quad")}: subdivided, they come near to the surface.`
          : "As few quads as go on as a control mesh in Design. This takes a while."}
      </Hint>
      <Buttons>
        <Button
          label={cage ? "Make cage again" : "Make cage"}
          busy={job !== undefined}
          disabled={view.trouble !== undefined}
          onClick={() => void page.make("cage")}
        />
        {cage && (
          <Button
            label="Use cage as mesh"
            icon="mesh"
            hint="Puts it among the open meshes, for Design"
            onClick={() => void keep(studio, view, "cage")}
          />
        )}
      </Buttons>
      {cage && (
        <Toggle
          label="Show the cage"
          value={page.sight(view) === "cage"}
          onChange={(on) => page.show(on ? "cage" : view.result ? "quads" : "input")}
        />
      )}
    </Section>
  );
}

async function keep(studio: Studio, view: QuadView, what: "quads" | "cage"): Promise<void> {
  if (view.result && !view.result.current && what === "quads")
    studio.notify("info", "These quads are of settings that were changed since.");
  if (await studio.do("document", "keep", { tab: "quad", what }))
    studio.notify("info", `“${studio.state!.meshes.at(-1)!.name}” is among the open meshes now.`);
}
