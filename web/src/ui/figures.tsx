import { count, short } from "./numbers.ts";

export type Figure = {
  label: string;
  /** Whole numbers are shown as counts, others with five digits. */
  value: number | string | null;
  unit?: string;
  hint?: string;
  /** It is not as it should be. */
  bad?: boolean;
};

/** Figures that tell what something is, and whether to trust it. */
export function Figures({ figures, label }: { figures: readonly Figure[]; label?: string }) {
  if (figures.length === 0) return null;
  return (
    <dl class="figures" aria-label={label}>
      {figures.map((figure) => (
        <div key={figure.label} class={figure.bad ? "bad" : undefined} title={figure.hint}>
          <dt>{figure.label}</dt>
          <dd>
            {shown(figure.value)}
            {figure.unit && <span class="unit"> {figure.unit}</span>}
          </dd>
        </div>
      ))}
    </dl>
  );
}

function shown(value: Figure["value"]): string {
  if (value === null) return "–";
  if (typeof value === "string") return value;
  return Number.isInteger(value) && Math.abs(value) < 1e12 ? count(value) : short(value);
}
