/** Shortcuts as people write them: "Ctrl+Shift+Z", "Space", "F", "?". */

const mac = /Mac|iP(hone|ad)/.test(navigator.platform);
const named: Record<string, string> = { " ": "Space", Esc: "Escape", Del: "Delete", Plus: "+" };

/** Whether the pressed keys are one of the shortcuts "A / B"; Command is as good as Control. */
export function pressed(event: KeyboardEvent, keys: string): boolean {
  return keys.split(" / ").some((one) => {
    const parts = one.split("+");
    const key = parts.pop() || "+";
    const wanted = named[key] ?? key;
    const is = named[event.key] ?? event.key;
    const letter = /^[a-z]$/i.test(wanted);
    const shifted = parts.includes("Shift");
    return (
      is.toLowerCase() === wanted.toLowerCase() &&
      (event.ctrlKey || event.metaKey) === parts.includes("Ctrl") &&
      event.altKey === parts.includes("Alt") &&
      // signs such as "?" need Shift on some keyboards, on others not
      (event.shiftKey === shifted || (!letter && wanted.length === 1))
    );
  });
}

/** As this machine's keyboard has it. */
export function shownKeys(keys: string): string {
  return mac
    ? keys
        .replace(/Ctrl/g, "⌘")
        .replace(/Shift/g, "⇧")
        .replace(/\+(?=.)/g, "")
    : keys;
}

/** A hint with its shortcut. */
export function keysTitle(hint: string | undefined, keys: string | undefined): string | undefined {
  if (!keys) return hint;
  return `${hint ?? ""} (${shownKeys(keys)})`.trim();
}

const moving = /^(Arrow.*|Home|End|PageUp|PageDown)$/;

/** Whether a key belongs to what has the focus: all to fields, arrows to sliders, Space to buttons. */
export function belongsToFocus(event: KeyboardEvent): boolean {
  const target = event.target as HTMLElement | null;
  if (!target || target === document.body) return false;
  if (target.isContentEditable || target.matches("textarea, select")) return true;
  if (target.matches(".viewer-viewport")) return moving.test(event.key);
  const kind = target instanceof HTMLInputElement ? target.type : null;
  if (kind === "range") return moving.test(event.key);
  const pressable = ["checkbox", "radio", "button"];
  if (kind !== null && !pressable.includes(kind)) return true;
  if (kind === null && !target.matches("button, a[href], [tabindex='0'][role]")) return false;
  const presses = kind === "radio" || kind === "checkbox" ? [" "] : [" ", "Enter"];
  return moving.test(event.key) || presses.includes(event.key);
}
