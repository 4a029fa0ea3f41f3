/** What the drawing is posed by, and where it goes in each frame. */
import { batch, computed, signal } from "@preact/signals";
import type { Flat, Point } from "../geometry/flat";
import { type Handle, type Move, STAY } from "../geometry/handles";
import { spots } from "../geometry/spots";

export const handles = signal<Handle[]>([]);
/** A move for every handle in each; there is always one. */
export const frames = signal<Move[][]>([[]]);
/** The number of the frame that is shown and changed. */
export const frame = signal(0);
/** Whether handles are placed on the drawing at rest, or moved. */
export const isPlacing = signal(true);

export const moves = computed((): Move[] => frames.value[frame.value] ?? []);

export function add(handle: Handle) {
  batch(() => {
    handles.value = [...handles.value, handle];
    frames.value = frames.value.map((moves) => [...moves, STAY]);
  });
}

export const addPoint = (at: Point) => add({ kind: "point", at });

export function remove(number: number) {
  batch(() => {
    handles.value = handles.value.toSpliced(number, 1);
    frames.value = frames.value.map((moves) => moves.toSpliced(number, 1));
  });
}

export function removeAll() {
  batch(() => {
    handles.value = [];
    [frames.value, frame.value] = [[[]], 0];
    isPlacing.value = true;
  });
}

export function replace(number: number, handle: Handle) {
  handles.value = handles.value.with(number, handle);
}

/** Moves one handle in the frame that is shown. */
export function move(number: number, to: Move) {
  frames.value = frames.value.with(frame.value, moves.value.with(number, to));
}

/** Adds a frame after the one that is shown, which starts as that one is. */
export function addFrame() {
  batch(() => {
    frames.value = frames.value.toSpliced(frame.value + 1, 0, moves.value);
    frame.value++;
  });
}

export function removeFrame() {
  batch(() => {
    frames.value = frames.value.toSpliced(frame.value, 1);
    frame.value = Math.min(frame.value, frames.value.length - 1);
  });
}

/** Handles that are set for whoever asks for it. */
const SOME = 6;

/** Sets points where the drawing is well held, to be moved at once. */
export function setSome(flat: Flat) {
  const set = spots(flat, SOME).map((at): Handle => ({ kind: "point", at }));
  setHandles(set, [set.map(() => STAY)]);
}

/** Takes handles of before with their frames; what does not belong together is left. */
export function setHandles(set: Handle[], moved: Move[][]) {
  if (moved.length === 0 || moved.some((moves) => moves.length !== set.length)) return;
  batch(() => {
    [handles.value, frames.value, frame.value] = [set, moved, 0];
    isPlacing.value = set.length === 0;
  });
}

export function rest() {
  frames.value = frames.value.with(
    frame.value,
    handles.value.map(() => STAY),
  );
}
