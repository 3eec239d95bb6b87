/** Numbers as people write and read them. */

/** As short as it can be at so many digits. */
export function short(value: number, digits = 5): string {
  if (!Number.isFinite(value)) return String(value);
  return String(Number(value.toPrecision(digits)));
}

/** A count with thin spaces: 1 234 567. */
export function count(value: number): string {
  return String(Math.round(value)).replace(/\B(?=(\d{3})+$)/g, "\u2009");
}

/** "1 vertex", "2 vertices". */
export function counted(value: number, one: string, many = `${one}s`): string {
  return `${count(value)} ${value === 1 ? one : many}`;
}

/** The number in a text, or null: a comma is read as a point. */
export function parsed(text: string): number | null {
  const value = Number(text.trim().replace(",", "."));
  return text.trim() === "" || !Number.isFinite(value) ? null : value;
}

export function clamped(value: number, min = -Infinity, max = Infinity): number {
  return Math.min(Math.max(value, min), max);
}

/** Rounded to the grid of a step, without the dust of binary fractions. */
export function stepped(value: number, step: number | undefined): number {
  if (!step) return value;
  const places = Math.min(Math.max(0, Math.ceil(-Math.log10(step)) + 2), 15);
  return Number((Math.round(value / step) * step).toFixed(places));
}

/** How long ago a time in seconds since 1970 is, in words. */
export function ago(seconds: number, now = Date.now() / 1000): string {
  const passed = Math.max(0, now - seconds);
  if (passed < 90) return "just now";
  if (passed < 3600) return `${Math.round(passed / 60)} minutes ago`;
  if (passed < 36 * 3600) return counted(Math.round(passed / 3600), "hour") + " ago";
  if (passed < 14 * 86400) return counted(Math.round(passed / 86400), "day") + " ago";
  return new Date(seconds * 1000).toLocaleDateString(undefined, { dateStyle: "medium" });
}
