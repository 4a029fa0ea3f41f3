/** What the pointer does on the sheet and on the mesh. */
import { signal } from "@preact/signals";

export type Tool = "pen" | "eraser" | "landmark" | "pose";

export const tool = signal<Tool>("pen");
/** Whether strokes are mirrored at the middle of the sheet. */
export const symmetric = signal(false);
