/** How the page is to look, kept in the browser. */
import { effect, signal } from "@preact/signals";
import type { Palette } from "../colour/maps";

export type Theme = "auto" | "light" | "dark";

function kept<T extends string>(key: string, values: readonly T[]) {
  const before = localStorage.getItem(key) as T | null;
  const preference = signal<T>(before && values.includes(before) ? before : (values[0] as T));
  effect(() => localStorage.setItem(key, preference.value));
  return preference;
}

const THEMES = ["auto", "light", "dark"] as const;
export const theme = kept<Theme>("theme", THEMES);
export const palette = kept<Palette>("palette", ["hues", "safe"]);

const prefersDark = matchMedia("(prefers-color-scheme: dark)");

/** Keeps the page in its theme. */
export function applyTheme() {
  const apply = () => {
    const isDark = theme.value === "dark" || (theme.value === "auto" && prefersDark.matches);
    document.documentElement.dataset.theme = isDark ? "dark" : "light";
  };
  prefersDark.addEventListener("change", apply);
  effect(apply);
}

export const isStill = () => matchMedia("(prefers-reduced-motion: reduce)").matches;
