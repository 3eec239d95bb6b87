/** What the colours of a viewport mean: a bar with numbers, or a list of names. */
import { gradient, type Colormap } from "./colormaps";

export type LegendContent =
  | {
      title: string;
      min: number;
      max: number;
      colormap: Exclude<Colormap, "categorical">;
      unit?: string;
    }
  | { title: string; entries: { label: string; colour: string }[] };

const TICKS = 5;

export class Legend {
  private readonly element = document.createElement("figure");

  constructor(parent: HTMLElement) {
    this.element.className = "viewer-legend";
    this.element.hidden = true;
    parent.append(this.element);
  }

  /** Shows a legend; null for none. */
  set(content: LegendContent | null): void {
    this.element.hidden = !content;
    this.element.replaceChildren();
    if (!content) return;
    this.element.append(made("figcaption", content.title));
    if ("entries" in content) this.list(content.entries);
    else this.bar(content);
  }

  private list(entries: { label: string; colour: string }[]): void {
    for (const { label, colour } of entries) {
      const row = made("p", label);
      const dot = made("i", "");
      dot.style.background = colour;
      row.prepend(dot);
      this.element.append(row);
    }
  }

  private bar(content: Extract<LegendContent, { min: number }>): void {
    const { min, max, colormap, unit } = content;
    if (unit) this.element.firstElementChild!.append(made("small", ` ${unit}`));
    const bar = made("div", "");
    bar.className = "viewer-bar";
    bar.style.background = gradient(colormap, "to top");
    for (const { value, text } of ticks(min, max)) {
      const tick = made("span", text);
      tick.style.bottom = `${max > min ? (100 * (value - min)) / (max - min) : 50}%`;
      bar.append(tick);
    }
    this.element.append(bar);
  }

  dispose(): void {
    this.element.remove();
  }
}

/** Round numbers between two limits, and the limits where no round one is close. */
export function ticks(min: number, max: number): { value: number; text: string }[] {
  if (!(max > min)) return [{ value: min, text: number(min, 0) }];
  const rough = (max - min) / (TICKS - 1);
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = power * ([1, 2, 5, 10].find((factor) => factor * power >= rough) ?? 10);
  const values: number[] = [];
  for (let k = Math.ceil(min / step - 1e-9); k * step <= max + 1e-9 * step; k++)
    values.push(k * step);
  const free = (limit: number) => values.every((value) => Math.abs(value - limit) > 0.4 * step);
  const all = [...[min, max].filter(free), ...values].sort((a, b) => a - b);
  return all.map((value) => ({ value, text: number(value, step) }));
}

/** A number, with as many digits as its step needs. */
function number(value: number, step: number): string {
  const size = Math.max(Math.abs(value), step);
  if (Math.abs(value) <= 1e-9 * size) return "0";
  if (size >= 1e5 || size < 1e-3) {
    return value.toExponential(1).replace("-", "\u2212");
  }
  const digits = step > 0 ? Math.max(0, -Math.floor(Math.log10(step) + 1e-9)) : 2;
  const exact = Math.abs(value / step - Math.round(value / step)) < 1e-6;
  return value.toFixed(Math.min(6, exact ? digits : digits + 1)).replace(/^-/, "\u2212");
}

function made(tag: string, text: string): HTMLElement {
  const element = document.createElement(tag);
  element.textContent = text;
  return element;
}
