/** The drawing on the sheet, with its past. */
import { computed, signal } from "@preact/signals";
import { type Drawing, EMPTY, isEmpty } from "../drawing/drawing";

/** Edits that can be taken back. */
const REMEMBERED = 200;

export const drawing = signal<Drawing>(EMPTY);
/** Which of the figures of the drawing is matched, from 0. */
export const figure = signal(0);

const past = signal<Drawing[]>([]);
const future = signal<Drawing[]>([]);

export const canUndo = computed(() => past.value.length > 0);
export const canRedo = computed(() => future.value.length > 0);
export const nothingDrawn = computed(() => isEmpty(drawing.value));

export function edit(next: Drawing) {
  past.value = [...past.value.slice(1 - REMEMBERED), drawing.value];
  future.value = [];
  show(next);
}

export function undo() {
  const before = past.value[past.value.length - 1];
  if (!before) return;
  past.value = past.value.slice(0, -1);
  future.value = [drawing.value, ...future.value];
  show(before);
}

export function redo() {
  const after = future.value[0];
  if (!after) return;
  future.value = future.value.slice(1);
  past.value = [...past.value, drawing.value];
  show(after);
}

function show(next: Drawing) {
  if (next.ground !== drawing.value.ground || isEmpty(next)) figure.value = 0;
  drawing.value = next;
}
