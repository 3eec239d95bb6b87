import type { ComponentChildren } from "preact";
import { useEffect, useRef, useState } from "preact/hooks";
import { Icon, type IconName } from "./icons.tsx";
import { keysTitle, shownKeys } from "./keys.ts";

export type MenuItem =
  | {
      label: string;
      onSelect(): void;
      /** A second, muted line. */
      detail?: string;
      keys?: string;
      icon?: IconName;
      /** For items that are on or off. */
      checked?: boolean;
      disabled?: boolean;
      hint?: string;
    }
  | { heading: string }
  | "line";

type MenuProps = {
  label: string;
  items: readonly MenuItem[];
  icon?: IconName;
  /** What stands before the label instead of an icon. */
  lead?: ComponentChildren;
  /** Only the icon is shown. */
  bare?: boolean;
  disabled?: boolean;
  hint?: string;
  keys?: string;
  /** Which edges of button and list are in line. */
  align?: "left" | "right";
};

/** A button that opens a list of things to do; arrow keys walk in it, Escape closes it. */
export function Menu(props: MenuProps) {
  const { label, items, icon, lead, bare, disabled, hint, keys, align = "left" } = props;
  const [open, setOpen] = useState(false);
  const place = useRef<HTMLDivElement>(null);
  const button = useRef<HTMLButtonElement>(null);
  const entries = () => [
    ...place.current!.querySelectorAll<HTMLElement>("[role^=menuitem]:not(:disabled)"),
  ];
  useEffect(() => {
    if (!open) return;
    const outside = (event: Event) =>
      place.current?.contains(event.target as Node) || setOpen(false);
    addEventListener("pointerdown", outside, true);
    entries()[0]?.focus();
    return () => removeEventListener("pointerdown", outside, true);
  }, [open]);

  function walk(event: KeyboardEvent) {
    if (!open) return;
    const all = entries();
    const at = all.indexOf(document.activeElement as HTMLElement);
    const to = { ArrowDown: at + 1, ArrowUp: at - 1, Home: 0, End: -1 }[event.key];
    if (to !== undefined) all.at(to % all.length)?.focus();
    else if (event.key === "Escape" || event.key === "Tab") close();
    else return;
    if (event.key !== "Tab") event.preventDefault();
    event.stopPropagation();
  }
  function close() {
    setOpen(false);
    button.current?.focus();
  }
  return (
    <div class={`menu ${align}`} ref={place} onKeyDown={walk}>
      <button
        type="button"
        ref={button}
        class={bare ? "icon-button" : "button quiet"}
        aria-label={label}
        aria-haspopup="menu"
        aria-expanded={open}
        title={keysTitle(hint ?? (bare ? label : undefined), keys)}
        disabled={disabled}
        onClick={() => setOpen(!open)}
      >
        {lead ?? (icon && <Icon name={icon} />)}
        {!bare && label}
        {!bare && <Icon name="down" size={12} />}
      </button>
      {open && (
        <div role="menu" aria-label={label}>
          {items.map((item, k) => (
            <Entry key={k} item={item} close={close} />
          ))}
        </div>
      )}
    </div>
  );
}

function Entry({ item, close }: { item: MenuItem; close(): void }) {
  if (item === "line") return <hr />;
  if ("heading" in item) return <div class="menu-heading">{item.heading}</div>;
  const switches = item.checked !== undefined;
  return (
    <button
      type="button"
      role={switches ? "menuitemcheckbox" : "menuitem"}
      aria-checked={item.checked}
      disabled={item.disabled}
      title={item.hint}
      onClick={() => {
        close();
        item.onSelect();
      }}
    >
      <span class="menu-icon">
        {switches ? item.checked && <Icon name="tick" /> : item.icon && <Icon name={item.icon} />}
      </span>
      <span class="menu-text">
        {item.label}
        {item.detail && <span class="detail">{item.detail}</span>}
      </span>
      {item.keys && <kbd>{shownKeys(item.keys)}</kbd>}
    </button>
  );
}
