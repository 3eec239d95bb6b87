/** Whose the mouse's wheel is: in a notebook, it scrolls that until the picture was clicked. */

/** Milliseconds that the hint stays. */
const HINT = 1400;

/** Milliseconds since the mouse moved over the picture up to which the wheel may be meant for it. */
const MEANT = 1500;

/** Lets the wheel through to the page around until a click within `element`. */
export function shareWheel(element: HTMLElement): void {
  if (window.parent === window) return;
  const hint = document.createElement("div");
  hint.className = "view-hint";
  hint.textContent = "Click the picture, then the wheel zooms";
  let ours = false;
  let waiting = 0;
  let moved = -Infinity;
  const hide = () => hint.remove();
  element.addEventListener("pointerdown", () => {
    ours = true;
    hide();
  });
  element.addEventListener("pointermove", ({ movementX, movementY }) => {
    if (movementX !== 0 || movementY !== 0) moved = performance.now(); // else the page was scrolled
  });
  document.documentElement.addEventListener("pointerleave", () => (ours = false));
  const wheel = (event: WheelEvent) => {
    if (ours || event.ctrlKey || document.fullscreenElement) return;
    event.stopImmediatePropagation();
    if (performance.now() - moved > MEANT) return;
    element.append(hint);
    window.clearTimeout(waiting);
    waiting = window.setTimeout(hide, HINT);
  };
  window.addEventListener("wheel", wheel, { capture: true, passive: true });
}
