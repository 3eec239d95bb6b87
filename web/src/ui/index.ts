/** The page's controls. They are controlled: they show what they are given, and tell of changes. */

export { Button, Buttons, IconButton } from "./buttons.tsx";
export { Choice, MeshChoice, type Option, Toggle } from "./choices.tsx";
export { Confirm, Dialog } from "./dialog.tsx";
export { NumberField, Slider, TextField, type Vector, VectorField } from "./fields.tsx";
export { type Figure, Figures } from "./figures.tsx";
export { useHeld } from "./held.ts";
export { Help, type HelpPart } from "./help.tsx";
export { Icon, type IconName, Sign } from "./icons.tsx";
export { belongsToFocus, keysTitle, pressed, shownKeys } from "./keys.ts";
export { List, type Row } from "./list.tsx";
export { Menu, type MenuItem } from "./menu.tsx";
export { ago, clamped, count, counted, short } from "./numbers.ts";
export { Progress } from "./progress.tsx";
export { Hint, type Level, Note, Section } from "./section.tsx";
export { type Toast, Toasts } from "./toasts.tsx";
