import { Button, Buttons, Note } from "../../ui/index.ts";
import type { Studio } from "../tab.ts";
import { page } from "./page.ts";
import type { Fix, Props, SideName, Trouble } from "./types.ts";

/** What to do now, what stands in the way, and the one button. */
export function Next({ state, view, studio }: Props) {
  const busy = studio.jobs.some((one) => one.tab === "combine" && one.title === "Combine");
  const again = view.result && !view.result.current;
  return (
    <div class="section section-body">
      {view.next && <Note level="info">{view.next}</Note>}
      {view.trouble && <TroubleNote trouble={view.trouble} studio={studio} />}
      {view.advice && <TroubleNote trouble={view.advice} studio={studio} />}
      {state.a !== null && state.b !== null && (
        <Button
          label={again ? "Combine again" : "Combine"}
          kind={view.result?.current ? "plain" : "primary"}
          keys="Enter"
          wide
          busy={busy}
          disabled={!view.ready}
          hint={view.trouble?.message ?? "One mesh with both forms"}
          onClick={() => void page.combine()}
        />
      )}
    </div>
  );
}

const fixes: Record<Fix, string> = {
  fill_holes: "Fill holes",
  flip_b: "Flip b",
  align: "Align b to a",
  propose: "Propose by shape",
  weld: "Weld duplicate vertices",
  oriented: "Turn faces to one side",
  largest_component: "Keep the largest piece",
  without_degenerate_faces: "Remove degenerate faces",
};

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
  else if (fix === "fill_holes" || fix === "flip_b" || fix === "align")
    await studio.do("combine", "change", { options: { [fix]: true } });
  else if (await studio.do("document", "keep", { tab: "combine", what: `${fix} ${side}` })) {
    const mesh = studio.state!.meshes.at(-1)!.id;
    await studio.do("combine", "use", { slot: side, mesh });
  }
}
