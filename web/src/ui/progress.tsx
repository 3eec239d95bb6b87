import { IconButton } from "./buttons.tsx";

type ProgressProps = {
  title: string;
  /** What is being done just now. */
  message?: string;
  /** In [0, 1]; null while it is not known. */
  fraction: number | null;
  onCancel?(): void;
};

/** How far long work is. */
export function Progress({ title, message, fraction, onCancel }: ProgressProps) {
  const percent = fraction === null ? null : Math.round(100 * Math.min(Math.max(fraction, 0), 1));
  return (
    <div class="progress">
      <div class="progress-text">
        <span class="progress-title">{title}</span>
        {message && <span class="detail">{message}</span>}
        {percent !== null && (
          <span class="percent">
            {percent}
            {"\u2009"}%
          </span>
        )}
        {onCancel && (
          <IconButton icon="close" size={12} label={`Cancel ${title}`} onClick={onCancel} />
        )}
      </div>
      <div
        class={`bar${percent === null ? " unknown" : ""}`}
        role="progressbar"
        aria-label={title}
        aria-valuemin={0}
        aria-valuemax={100}
        aria-valuenow={percent ?? undefined}
      >
        <span style={percent === null ? undefined : { width: `${percent}%` }} />
      </div>
    </div>
  );
}
