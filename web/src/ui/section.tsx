import type { ComponentChildren } from "preact";
import { useId, useState } from "preact/hooks";
import { Icon } from "./icons.tsx";

type SectionProps = {
  title: string;
  /** Its place in the order of work, for panels that lead through a task. */
  step?: number;
  /** That step is done. */
  done?: boolean;
  /** Whether it is open at first; true by default. */
  open?: boolean;
  /** What stands at the right of its title: a count, a small button. */
  aside?: ComponentChildren;
  children?: ComponentChildren;
};

const folded = new Map<string, boolean>(); // as people left them, by title

/** A part of a panel that can be folded. */
export function Section({ title, step, done, open = true, aside, children }: SectionProps) {
  const id = useId();
  const [shown, setShown] = useState(!(folded.get(title) ?? !open));
  return (
    <section class="section" aria-labelledby={id}>
      <header>
        <button
          type="button"
          class="fold"
          id={id}
          aria-expanded={shown}
          aria-controls={`${id}-body`}
          onClick={() => {
            folded.set(title, shown);
            setShown(!shown);
          }}
        >
          <Icon name={shown ? "down" : "right"} size={12} />
          {step !== undefined && (
            <span class={`step${done ? " done" : ""}`}>
              {done ? <Icon name="tick" size={10} /> : step}
            </span>
          )}
          {title}
        </button>
        {aside !== undefined && <span class="aside">{aside}</span>}
      </header>
      {shown && (
        <div class="section-body" id={`${id}-body`}>
          {children}
        </div>
      )}
    </section>
  );
}

/** A few muted words of explanation. */
export function Hint({ children }: { children: ComponentChildren }) {
  return <p class="hint">{children}</p>;
}

/** A note that stands out: what is not as it should be, and what to do. */
export function Note(props: { level?: Level; children: ComponentChildren }) {
  const { level = "warning", children } = props;
  return (
    <div class={`note ${level}`} role={level === "info" ? "note" : "alert"}>
      <Icon name={level === "info" ? "info" : "warning"} size={14} />
      <div>{children}</div>
    </div>
  );
}

export type Level = "info" | "warning" | "error";
