import { useEffect, useState } from "preact/hooks";
import { clamped } from "../ui/index.ts";
import { keep, kept } from "./kept.ts";

const usual = 320;
const narrowest = 260;
const widest = 560;

/** Between stage and panel; dragged, or moved by arrow keys; a double click takes it back. */
export function Divider() {
  const [width, setWidth] = useState(kept("panel", usual));
  useEffect(() => {
    document.documentElement.style.setProperty("--panel-width", `${width}px`);
    keep("panel", width);
  }, [width]);
  const set = (next: number) => setWidth(clamped(Math.round(next), narrowest, widest));
  return (
    <div
      class="divider"
      role="separator"
      aria-orientation="vertical"
      aria-label="Width of the panel"
      aria-valuenow={width}
      aria-valuemin={narrowest}
      aria-valuemax={widest}
      tabIndex={0}
      onDblClick={() => set(usual)}
      onPointerDown={(event) => event.currentTarget.setPointerCapture(event.pointerId)}
      onPointerMove={(event) => {
        if (event.currentTarget.hasPointerCapture(event.pointerId)) set(innerWidth - event.clientX);
      }}
      onKeyDown={(event) => {
        const by = { ArrowLeft: 16, ArrowRight: -16 }[event.key];
        if (!by) return;
        event.preventDefault();
        set(width + by);
      }}
    />
  );
}
