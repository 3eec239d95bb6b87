import { useState } from "preact/hooks";
import type { ExportFormat, OptionValue } from "../state.ts";
import { Button, Choice, Dialog, Menu, type MenuItem, TextField, Toggle } from "../ui/index.ts";
import type { App } from "./app.ts";

/** All that can be saved from the tab, and what may be chosen about it. */
export function Exports({ app }: { app: App }) {
  const [asking, setAsking] = useState<ExportFormat | null>(null);
  const tab = app.tab.name;
  const formats = app.state?.tabs[tab]?.view.exports ?? [];
  return (
    <>
      <Menu
        label="Export"
        icon="export"
        align="right"
        disabled={formats.length === 0}
        hint={formats.length === 0 ? "There is nothing to export in this tab yet" : undefined}
        items={itemsOf(formats, (format) =>
          format.choices?.length ? setAsking(format) : void app.exportAs(tab, format.format),
        )}
      />
      {asking && (
        <Options
          format={asking}
          onExport={(options) => void app.exportAs(tab, asking.format, options)}
          onClose={() => setAsking(null)}
        />
      )}
    </>
  );
}

/** Formats under the headings of their groups. */
function itemsOf(formats: readonly ExportFormat[], choose: (format: ExportFormat) => void) {
  const items: MenuItem[] = [];
  let group = "";
  for (const format of formats) {
    if (format.group && format.group !== group) items.push({ heading: (group = format.group) });
    items.push({
      label: format.choices?.length ? `${format.label} …` : format.label,
      detail: format.detail,
      icon: "download",
      disabled: format.missing !== undefined,
      onSelect: () => choose(format),
    });
  }
  return items;
}

type OptionsProps = {
  format: ExportFormat;
  onExport(options: Record<string, OptionValue>): void;
  onClose(): void;
};

function Options({ format, onExport, onClose }: OptionsProps) {
  const [options, setOptions] = useState(format.options ?? {});
  const set = (name: string, value: OptionValue) => setOptions({ ...options, [name]: value });
  return (
    <Dialog
      title={`Export: ${format.label}`}
      onClose={onClose}
      actions={
        <>
          <Button label="Cancel" onClick={onClose} />
          <Button
            label="Export"
            kind="primary"
            onClick={() => {
              onClose();
              onExport(options);
            }}
          />
        </>
      }
    >
      {format.choices?.map(({ name, label, choices }) => {
        const value = options[name];
        if (typeof value === "boolean")
          return <Toggle label={label} value={value} onChange={(next) => set(name, next)} />;
        if (typeof value === "string")
          return (
            <Choice
              label={label}
              value={value}
              options={choices.map((one) => ({ value: one, label: one }))}
              onChange={(next) => set(name, next)}
            />
          );
        return (
          <TextField
            label={label}
            value={(value ?? []).join(", ")}
            hint="Numbers, with commas between them"
            onChange={(text) => set(name, numbersIn(text))}
          />
        );
      })}
    </Dialog>
  );
}

function numbersIn(text: string): number[] {
  return text
    .split(/[\s,;]+/)
    .filter(Boolean)
    .map(Number)
    .filter(Number.isFinite);
}
