/** The page's icons: strokes on a grid of 16, in the colour of the text. */

const shapes = {
  undo: "M6 3 2.5 6.5 6 10M2.5 6.5H10a3.5 3.5 0 0 1 0 7H6",
  redo: "M10 3l3.5 3.5L10 10M13.5 6.5H6a3.5 3.5 0 0 0 0 7h4",
  open: "M1.5 12.5v-9h4l1.5 2h6v2M1.5 12.5l2-5h11l-2 5z",
  export: "M8 10V2M5 5l3-3 3 3M2.5 9.5v4h11v-4",
  download: "M8 2v8M5 7l3 3 3-3M2.5 9.5v4h11v-4",
  sun: "M8 5a3 3 0 1 0 0 6 3 3 0 0 0 0-6zM8 1v1.5M8 13.5V15M1 8h1.5M13.5 8H15M3 3l1 1M12 12l1 1M13 3l-1 1M4 12l-1 1",
  moon: "M13.5 9.6A6 6 0 0 1 6.4 2.5a6 6 0 1 0 7.1 7.1z",
  help: "M5.8 6a2.2 2.2 0 1 1 3.3 1.9C8.3 8.4 8 8.8 8 9.7M8 12.2v.1M8 1.5a6.5 6.5 0 1 0 0 13 6.5 6.5 0 0 0 0-13z",
  close: "M3.5 3.5l9 9M12.5 3.5l-9 9",
  plus: "M8 3v10M3 8h10",
  minus: "M3 8h10",
  tick: "M3 8.5l3.5 3.5L13 4.5",
  down: "M4 6l4 4 4-4",
  right: "M6 4l4 4-4 4",
  frame:
    "M2 5.5V2h3.5M10.5 2H14v3.5M14 10.5V14h-3.5M5.5 14H2v-3.5M8 6.5a1.5 1.5 0 1 0 0 3 1.5 1.5 0 0 0 0-3z",
  orbit:
    "M8 5.5a2.5 2.5 0 1 0 0 5 2.5 2.5 0 0 0 0-5zM2.5 11.8c-2.2-2.6 5.5-9.7 9-8.9 3.3.8-1.3 8.7-6.5 10.2",
  pick: "M3 2l4 11 1.7-4.3L13 7z",
  rectangle: "M2.5 3.5h11v9h-11z",
  lasso:
    "M5 11.5C2.7 10.8 1.5 9.2 1.5 7.4 1.5 4.6 4.5 2.5 8.2 2.5s6.3 1.9 6.3 4.5-2.8 4.7-6.5 4.7c-.9 0-1.8-.1-2.6-.3M5.4 11.4a1.3 1.3 0 1 0-2 1.5c.9.6 1.3 1 1 2.1",
  brush:
    "M13.8 2.2C11 3.5 8 6.5 6.8 8.8l1.5 1.5c2.3-1.2 4.7-4.8 5.5-8.1zM6 9.6c-2 0-2.5 1.3-2.6 2.4-.1.8-.7 1.3-1.6 1.5 2.2.8 5.2.3 5.7-2.3z",
  move: "M8 1.5v13M1.5 8h13M6 3.5l2-2 2 2M6 12.5l2 2 2-2M3.5 6l-2 2 2 2M12.5 6l2 2-2 2",
  pin: "M8 14.5c-3-3.6-4.5-6-4.5-8.2a4.5 4.5 0 1 1 9 0c0 2.2-1.5 4.6-4.5 8.2zM8 4.7a1.6 1.6 0 1 0 0 3.2 1.6 1.6 0 0 0 0-3.2z",
  curve: "M1.5 12.5c4 1 3-8 6.5-8s2.5 9 6.5 8M1.5 10.5v4M14.5 10.5v4",
  edges: "M8 1.5l6 3.5v6.5l-6 3-6-3V5zM2 5l6 3 6-3M8 8v6.5",
  smooth: "M8 2a6 6 0 1 0 0 12A6 6 0 0 0 8 2zM4.8 6.5A4 4 0 0 1 7.5 4.3",
  flat: "M8 2l5 3v6l-5 3-5-3V5zM8 8l5-3M8 8L3 5M8 8v6",
  view: "M1.5 8c2-3.3 4.2-5 6.5-5s4.5 1.7 6.5 5c-2 3.3-4.2 5-6.5 5S3.5 11.3 1.5 8zM8 6a2 2 0 1 0 0 4 2 2 0 0 0 0-4z",
  hide: "M1.5 8c2-3.3 4.2-5 6.5-5s4.5 1.7 6.5 5c-2 3.3-4.2 5-6.5 5S3.5 11.3 1.5 8zM2.5 13.5l11-11",
  mesh: "M2 12.5L6 3l7.5 2.5L11 13zM6 3l1.5 5.5L11 13M2 12.5l5.5-4 6-3",
  trash: "M2.5 4.5h11M6 4.5v-2h4v2M4 4.5l.7 9h6.6l.7-9M6.7 7v4M9.3 7v4",
  rename: "M10.5 2.5l3 3-8 8H2.5v-3zM8.8 4.2l3 3",
  warning: "M8 2l6.5 11.5h-13zM8 6.5v3.5M8 11.8v.1",
  info: "M8 1.5a6.5 6.5 0 1 0 0 13 6.5 6.5 0 0 0 0-13zM8 7.5v4M8 4.8v.1",
  play: "M4.5 2.5v11l9-5.5z",
  pause: "M5 3v10M11 3v10",
  clock: "M8 1.5a6.5 6.5 0 1 0 0 13 6.5 6.5 0 0 0 0-13zM8 4.5V8l2.5 1.5",
  link: "M6.5 9.5l3-3M7 4.5l1.3-1.3a3.2 3.2 0 0 1 4.5 4.5L11.5 9M9 11.5l-1.3 1.3a3.2 3.2 0 0 1-4.5-4.5L4.5 7",
  list: "M5.5 4H14M5.5 8H14M5.5 12H14M2 4h.5M2 8h.5M2 12h.5",
} as const;

export type IconName = keyof typeof shapes;

/** An icon, for people who see; its meaning is in the label of what it stands in. */
export function Icon({ name, size = 16 }: { name: IconName; size?: number }) {
  return (
    <svg class="icon" width={size} height={size} viewBox="0 0 16 16" aria-hidden="true">
      <path d={shapes[name]} />
    </svg>
  );
}

/** The sign of henkei: one form becoming another. */
export function Sign({ size = 20 }: { size?: number }) {
  return (
    <svg class="sign" width={size} height={size} viewBox="0 0 20 20" aria-hidden="true">
      <path class="sign-a" d="M3 4.5 10 1l7 3.5v11L10 19l-7-3.5z" />
      <path class="sign-b" d="M10 1c5 1.5 7 5 7 9s-2 7.5-7 9c-5-1.5-7-5-7-9s2-7.5 7-9z" />
      <path class="sign-c" d="M3 10c4.5 2.6 9.5 2.6 14 0" />
    </svg>
  );
}
