import {
  Button,
  Buttons,
  Choice,
  Figures,
  MeshChoice,
  Note,
  Section,
  Toggle,
} from "../../ui/index.ts";
import type { Studio } from "../tab.ts";
import { Landmarks } from "./landmarks.tsx";
import { Morphs } from "./morphs.tsx";
import { Options } from "./options.tsx";
import { page } from "./page.ts";
import { type Fix, type Props, type RegisterView, type Result, type Trouble } from "./types.ts";

/** What to do next is at the top; below it, what belongs to what is looked at. */
export function Panel(props: Props) {
  const { state, view } = props;
  const mode = page.shown;
  const both = state.source !== null && state.target !== null;
  return (
    <>
      <Next {...props} />
      {(view.result || page.job) && <Looking view={view} />}
      {mode === "sides" && <Surfaces {...props} />}
      {mode === "sides" && both && <Landmarks {...props} />}
      {mode === "sides" && both && <Options {...props} />}
      {mode === "model" && view.result && !page.job && (
        <>
          <Morphs {...props} result={view.result} />
          <Colours result={view.result} />
          <Section title="Figures">
            <Figures label="Figures of the registration" figures={view.result.figures} />
          </Section>
        </>
      )}
    </>
  );
}

/** What to do now, what stands in the way, and the one button. */
function Next({ state, view, studio }: Props) {
  const { job } = page;
  const again = view.result && !view.result.current;
  return (
    <div class="section section-body">
      {view.next && !job && <Note level="info">{view.next}</Note>}
      {view.trouble && <TroubleNote trouble={view.trouble} studio={studio} />}
      {state.source !== null && state.target !== null && (
        <Button
          label={again ? "Register again" : "Register"}
          kind={view.result?.current ? "plain" : "primary"}
          keys="Enter"
          wide
          busy={job !== undefined}
          disabled={!view.ready}
          hint={view.trouble?.message ?? "Give the source the form of the target"}
          onClick={() => void page.register()}
        />
      )}
    </div>
  );
}

const fixes: Record<Fix, string> = {
  weld: "Weld duplicate vertices",
  oriented: "Turn faces to one side",
  largest_component: "Keep the largest piece",
  without_degenerate_faces: "Remove degenerate faces",
  flipped: "Turn its faces round",
};

function TroubleNote({ trouble, studio }: { trouble: Trouble; studio: Studio }) {
  const { message, side } = trouble;
  return (
    <Note>
      {message}
      <Buttons>
        {trouble.fixes.map((fix) => (
          <Button key={fix} label={fixes[fix]} onClick={() => void mend(studio, fix, side)} />
        ))}
        {side === "" && (
          <Button
            label="Clear landmarks"
            onClick={() => void studio.do("register", "clear_landmarks")}
          />
        )}
      </Buttons>
    </Note>
  );
}

/** Takes a mended copy in place of a mesh. */
async function mend(studio: Studio, fix: Fix, slot: string): Promise<void> {
  const what = `${fix} ${slot}`;
  if (!(await studio.do("document", "keep", { tab: "register", what }))) return;
  await studio.do("register", "use", { slot, mesh: studio.state!.meshes.at(-1)!.id });
}

function Looking({ view }: { view: RegisterView }) {
  return (
    <Section title="Look at">
      <Choice
        label="Show"
        as="segments"
        value={page.shown}
        options={[
          { value: "sides", label: "Both meshes", hint: "Side by side, with landmarks (S)" },
          { value: "model", label: "Model", hint: "The model over the target (M)" },
        ]}
        onChange={(mode) => page.show(mode)}
      />
      {page.shown === "model" && (
        <>
          <Toggle
            label="Show the target"
            hint="Seen through, behind the model"
            value={page.ghost}
            onChange={(ghost) => page.set({ ghost })}
          />
          {view.result && view.result.landmarks.length > 0 && !page.job && (
            <Toggle
              label="Mark landmarks"
              value={page.marked}
              onChange={(marked) => page.set({ marked })}
            />
          )}
        </>
      )}
    </Section>
  );
}

function Surfaces({ state, studio }: Props) {
  const meshes = studio.state?.meshes ?? [];
  const use = (slot: string) => (mesh: string | null) =>
    studio.do("register", "use", { slot, mesh });
  return (
    <Section title="Meshes to register">
      <MeshChoice
        label="Source"
        hint="Its vertices and faces are kept: the template"
        meshes={meshes}
        value={state.source}
        onChange={use("source")}
      />
      <MeshChoice
        label="Target"
        hint="Its form is taken on: the scan"
        meshes={meshes}
        value={state.target}
        onChange={use("target")}
      />
      <Toggle
        label="Link cameras"
        hint="Both are seen from the same side"
        value={page.linked}
        onChange={(linked) => page.set({ linked })}
      />
      <Buttons>
        <Button
          label="Swap"
          kind="quiet"
          hint="Exchange source and target"
          onClick={() => void studio.do("register", "swap")}
        />
      </Buttons>
    </Section>
  );
}

function Colours({ result }: { result: Result }) {
  const { colours } = result;
  return (
    <Section title="Colours">
      <Choice
        label="Colour by"
        as="select"
        value={colours.some((one) => one.title === page.colour) ? page.colour : ""}
        options={[
          { value: "", label: "nothing" },
          ...colours.map(({ title }) => ({ value: title, label: title })),
        ]}
        onChange={(colour) => page.set({ colour })}
      />
    </Section>
  );
}
