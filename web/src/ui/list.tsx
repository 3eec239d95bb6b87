import type { ComponentChildren } from "preact";
import { useState } from "preact/hooks";
import { IconButton } from "./buttons.tsx";
import type { Answer } from "./held.ts";

export type Row = {
  id: string;
  name: string;
  /** CSS colour of its dot. */
  colour?: string;
  /** Muted, at the right. */
  detail?: string;
  selected?: boolean;
  /** Whether its box is ticked; without it, there is no box. */
  ticked?: boolean;
  /** Something is wrong with it. */
  bad?: boolean;
  hint?: string;
  /** Stands below it, as wide as the list: sliders of a selected row, a longer explanation. */
  below?: ComponentChildren;
  /** Further small buttons of this row. */
  buttons?: ComponentChildren;
};

type ListProps = {
  /** What it is a list of. */
  label: string;
  rows: readonly Row[];
  onSelect?(id: string, event: MouseEvent): void;
  /** Double click, or F2, on the name. */
  onRename?(id: string, name: string): Answer;
  onRemove?(id: string): void;
  onTick?(id: string, ticked: boolean): Answer;
  onHover?(id: string | null): void;
  /** Shown instead when there are no rows. */
  empty?: string;
};

/** Rows that can be chosen, ticked, renamed and removed. */
export function List(props: ListProps) {
  const { label, rows, empty, onHover } = props;
  if (rows.length === 0) return empty ? <p class="hint">{empty}</p> : null;
  return (
    <ul class="list" aria-label={label} onPointerLeave={() => onHover?.(null)}>
      {rows.map((row) => (
        <ListRow key={row.id} row={row} list={props} />
      ))}
    </ul>
  );
}

function ListRow({ row, list }: { row: Row; list: ListProps }) {
  const { onSelect, onRename, onRemove, onTick, onHover } = list;
  const [renaming, setRenaming] = useState(false);
  const name = row.colour ? (
    <>
      <span class="dot" style={{ background: row.colour }} />
      <span class="name">{row.name}</span>
    </>
  ) : (
    <span class="name">{row.name}</span>
  );
  return (
    <li
      class={`row${row.selected ? " selected" : ""}${row.bad ? " bad" : ""}`}
      title={row.hint}
      onPointerEnter={() => onHover?.(row.id)}
    >
      <div class="row-line">
        {row.ticked !== undefined && (
          <input
            type="checkbox"
            aria-label={row.name}
            checked={row.ticked}
            onChange={(event) => void onTick?.(row.id, event.currentTarget.checked)}
          />
        )}
        {renaming ? (
          <Rename
            name={row.name}
            onEnd={(next) => {
              setRenaming(false);
              if (next && next !== row.name) void onRename?.(row.id, next);
            }}
          />
        ) : (
          <button
            type="button"
            class="row-name"
            aria-pressed={onSelect && (row.selected ?? false)}
            onClick={(event) =>
              onSelect
                ? onSelect(row.id, event)
                : row.ticked !== undefined && void onTick?.(row.id, !row.ticked)
            }
            onDblClick={() => onRename && setRenaming(true)}
            onKeyDown={(event) => {
              if (event.key === "F2" && onRename) setRenaming(true);
              if (event.key === "Delete" && onRemove) {
                event.preventDefault(); // it is not for what is chosen elsewhere
                onRemove(row.id);
              }
            }}
          >
            {name}
          </button>
        )}
        {row.detail && <span class="detail">{row.detail}</span>}
        <span class="row-buttons">
          {row.buttons}
          {onRename && !renaming && (
            <IconButton
              icon="rename"
              size={12}
              label={`Rename ${row.name}`}
              onClick={() => setRenaming(true)}
            />
          )}
          {onRemove && (
            <IconButton
              icon="close"
              size={12}
              label={`Remove ${row.name}`}
              onClick={() => onRemove(row.id)}
            />
          )}
        </span>
      </div>
      {row.below && <div class="row-below">{row.below}</div>}
    </li>
  );
}

function Rename({ name, onEnd }: { name: string; onEnd(name: string | null): void }) {
  return (
    <input
      class="text"
      type="text"
      aria-label={`New name of ${name}`}
      value={name}
      ref={(field) => {
        if (field && document.activeElement !== field) {
          field.focus();
          field.select();
        }
      }}
      onBlur={(event) => onEnd(event.currentTarget.value.trim())}
      onKeyDown={(event) => {
        if (event.key === "Enter") event.currentTarget.blur();
        if (event.key === "Escape") {
          event.stopPropagation();
          event.currentTarget.value = name;
          event.currentTarget.blur();
        }
      }}
    />
  );
}
