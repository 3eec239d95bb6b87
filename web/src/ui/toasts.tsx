import { useEffect, useRef } from "preact/hooks";
import { Button, IconButton } from "./buttons.tsx";
import { Icon } from "./icons.tsx";
import type { Level } from "./section.tsx";

export type Toast = {
  id: number;
  level: Level;
  text: string;
  /** How often it was said. */
  times: number;
  /** It is of a file that was not opened; of no use once others are. */
  ofFile?: boolean;
  /** Something to do about it. */
  action?: { label: string; run(): void };
};

const shortest = 6000; // milliseconds, for what is good to know
const perCharacter = 45;

/** Messages at the corner. What is good to know goes away by itself; the rest stays until closed. */
export function Toasts({
  toasts,
  onClose,
}: {
  toasts: readonly Toast[];
  onClose(id: number): void;
}) {
  return (
    <div class="toasts" role="region" aria-label="Messages">
      {toasts.map((toast) => (
        <OneToast key={toast.id} toast={toast} onClose={() => onClose(toast.id)} />
      ))}
    </div>
  );
}

function OneToast({ toast, onClose }: { toast: Toast; onClose(): void }) {
  const timer = useRef(0);
  const start = () => {
    clearTimeout(timer.current);
    if (toast.level === "info")
      timer.current = setTimeout(onClose, Math.max(shortest, perCharacter * toast.text.length));
  };
  useEffect(() => {
    start();
    return () => clearTimeout(timer.current);
  }, [toast.times, toast.text]);
  return (
    <div
      class={`toast ${toast.level}`}
      role={toast.level === "info" ? "status" : "alert"}
      onPointerEnter={() => clearTimeout(timer.current)}
      onPointerLeave={start}
    >
      <Icon name={toast.level === "info" ? "info" : "warning"} />
      <div class="toast-text">
        {toast.text}
        {toast.times > 1 && <span class="times"> × {toast.times}</span>}
        {toast.action && (
          <div>
            <Button label={toast.action.label} onClick={toast.action.run} />
          </div>
        )}
      </div>
      <IconButton icon="close" size={12} label="Dismiss" onClick={onClose} />
    </div>
  );
}
