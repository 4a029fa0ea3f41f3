/** Keys that work anywhere on the page but where something is typed. */
import { lookAsDrawn } from "../view/camera";
import { redo, undo } from "./drawing";
import { symmetric, tool } from "./tools";

const PLAIN: Record<string, () => void> = {
  p: () => {
    tool.value = "pen";
  },
  e: () => {
    tool.value = "eraser";
  },
  l: () => {
    tool.value = "landmark";
  },
  h: () => {
    tool.value = "pose";
  },
  s: () => {
    symmetric.value = !symmetric.value;
  },
  v: lookAsDrawn,
};

const isTyping = (target: EventTarget | null) =>
  target instanceof HTMLElement && target.matches("input, select, textarea, dialog *");

export function shortcuts() {
  addEventListener("keydown", (event) => {
    if (isTyping(event.target) || event.altKey) return;
    const key = event.key.toLowerCase();
    const does = event.ctrlKey || event.metaKey ? withControl(key, event.shiftKey) : PLAIN[key];
    if (!does) return;
    event.preventDefault();
    does();
  });
}

function withControl(key: string, isShifted: boolean): (() => void) | undefined {
  if (key === "z") return isShifted ? redo : undo;
  return key === "y" ? redo : undefined;
}
