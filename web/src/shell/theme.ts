import { keep, kept } from "./kept.ts";

export type Theme = "light" | "dark";

const system = matchMedia("(prefers-color-scheme: dark)");

/** What was chosen, or else what the system has. */
export function theme(): Theme {
  return kept<Theme | null>("theme", null) ?? (system.matches ? "dark" : "light");
}

export function chooseTheme(next: Theme): void {
  keep("theme", next);
}

/** Puts the theme on the page, now and when the system's changes. */
export function followTheme(changed: (theme: Theme) => void): () => void {
  const follow = () => {
    document.documentElement.dataset.theme = theme();
    changed(theme());
  };
  system.addEventListener("change", follow);
  follow();
  return follow;
}
