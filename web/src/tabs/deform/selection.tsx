import { Button, Buttons, counted, IconButton, Section, Slider, Toggle } from "../../ui/index.ts";
import type { Studio } from "../tab.ts";
import { memory } from "./memory.ts";
import { add, selectNothing } from "./selecting.ts";
import type { DeformView } from "./types.ts";

/** What is selected, and what it is to become. */
export function Selection({ view, studio }: { view: DeformView; studio: Studio }) {
  const { selected = 0, parts = [] } = view;
  const none = selected === 0;
  const fixed = parts.some((part) => part.kind === "fixed");
  const grow = (rings: number) => void studio.do("deform", "grow", { rings });
  return (
    <Section
      title="Selection"
      aside={
        <>
          <span class="detail">{none ? "nothing" : counted(selected, "vertex", "vertices")}</span>
          {!none && (
            <IconButton
              icon="close"
              size={12}
              label="Select nothing"
              keys="N"
              onClick={() => void selectNothing(studio)}
            />
          )}
        </>
      }
    >
      <Buttons>
        <Button
          label="Fix"
          keys="X"
          hint="The selection stays where it is"
          kind={none || fixed ? "plain" : "primary"}
          disabled={none}
          onClick={() => void add(studio, "fixed")}
        />
        <Button
          label="Handle"
          keys="H"
          hint="The selection is moved as one piece"
          kind={none || !fixed ? "plain" : "primary"}
          disabled={none}
          onClick={() => void add(studio, "handles")}
        />
        <Button
          label="Feature"
          keys="K"
          hint="The selection keeps its shape, and goes along"
          disabled={none}
          onClick={() => void add(studio, "features")}
        />
      </Buttons>
      <Buttons>
        <Button label="Grow" keys="G" kind="quiet" disabled={none} onClick={() => grow(1)} />
        <Button
          label="Shrink"
          keys="Shift+G"
          kind="quiet"
          disabled={none}
          onClick={() => grow(-1)}
        />
        <Button
          label="Invert"
          keys="I"
          kind="quiet"
          onClick={() => void studio.do("deform", "invert")}
        />
      </Buttons>
      {studio.tool.name === "brush" && (
        <Slider
          label="Brush"
          hint="Radius, of half the mesh's diagonal; keys [ and ]"
          value={Math.round(1000 * memory.brush) / 10}
          min={0.5}
          max={50}
          logarithmic
          unit="%"
          onInput={(percent) => {
            memory.brush = percent / 100;
            studio.changed();
          }}
          onChange={(percent) => {
            memory.brush = percent / 100;
            studio.changed();
          }}
        />
      )}
      {(studio.tool.name === "rectangle" || studio.tool.name === "lasso") && (
        <Toggle
          label="Hidden ones too"
          hint="Rectangle and lasso also select what the surface hides"
          value={memory.hidden}
          onChange={(hidden) => {
            memory.hidden = hidden;
            studio.changed();
          }}
        />
      )}
    </Section>
  );
}
