import type { ComponentChildren } from "preact";
import { Icon, type IconName } from "./icons.tsx";
import { keysTitle } from "./keys.ts";

type ButtonProps = {
  /** What it does: its text, unless there are children. */
  label: string;
  onClick(event: MouseEvent): void;
  kind?: "plain" | "primary" | "danger" | "quiet";
  icon?: IconName;
  disabled?: boolean;
  /** Work that it began goes on. */
  busy?: boolean;
  hint?: string;
  /** Its shortcut, for the hint. */
  keys?: string;
  wide?: boolean;
  children?: ComponentChildren;
};

/** A button with text. */
export function Button(props: ButtonProps) {
  const {
    label,
    onClick,
    kind = "plain",
    icon,
    disabled,
    busy,
    hint,
    keys,
    wide,
    children,
  } = props;
  return (
    <button
      type="button"
      class={`button ${kind}${wide ? " wide" : ""}`}
      title={keysTitle(hint, keys)}
      aria-label={children ? label : undefined}
      aria-busy={busy}
      disabled={disabled || busy}
      onClick={onClick}
    >
      {busy ? <span class="spinner" /> : icon && <Icon name={icon} />}
      {children ?? label}
    </button>
  );
}

type IconButtonProps = {
  icon: IconName;
  /** Its name, read aloud and shown as a hint. */
  label: string;
  onClick(event: MouseEvent): void;
  /** For buttons that are on or off. */
  pressed?: boolean;
  disabled?: boolean;
  hint?: string;
  keys?: string;
  size?: number;
};

/** A button that is only an icon. */
export function IconButton(props: IconButtonProps) {
  const { icon, label, onClick, pressed, disabled, hint, keys, size } = props;
  return (
    <button
      type="button"
      class="icon-button"
      aria-label={label}
      aria-pressed={pressed}
      title={keysTitle(hint ? `${label}: ${hint}` : label, keys)}
      disabled={disabled}
      onClick={onClick}
    >
      <Icon name={icon} size={size} />
    </button>
  );
}

/** Buttons that belong together, in one row. */
export function Buttons({ children }: { children: ComponentChildren }) {
  return <div class="buttons">{children}</div>;
}
