/** Whose the mouse's wheel is: in a notebook, it scrolls that until the picture was clicked. */

/** Milliseconds that the hint stays. */
const HINT = 1400;

/** Lets the wheel through to the page around until a click within `element`. */
export function shareWheel(element: HTMLElement): void {
  if (window.parent === window) return;
  const hint = document.createElement("div");
  hint.className = "view-hint";
  hint.textContent = "Click the picture, then the wheel zooms";
  let ours = false;
  let waiting = 0;
  const hide = () => hint.remove();
  element.addEventListener("pointerdown", () => {
    ours = true;
    hide();
  });
  document.documentElement.addEventListener("pointerleave", () => (ours = false));
  const wheel = (event: WheelEvent) => {
    if (ours || event.ctrlKey || document.fullscreenElement) return;
    event.stopImmediatePropagation();
    if (!element.contains(event.target as Node)) return;
    element.append(hint);
    window.clearTimeout(waiting);
    waiting = window.setTimeout(hide, HINT);
  };
  window.addEventListener("wheel", wheel, { capture: true, passive: true });
}
