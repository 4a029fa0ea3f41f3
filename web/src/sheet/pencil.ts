/** What the pen and the eraser do while they are down. */
import { signal } from "@preact/signals";
import { type Drawing, mirrored, type Stroke, unit, withStrokes } from "../drawing/drawing";
import { erased, extended } from "../drawing/stroke";
import type { Point } from "../geometry/flat";
import { drawing, edit } from "../state/drawing";
import { symmetric, tool } from "../state/tools";

/** The drawing with the edit under way; nothing while the pen is up. */
export const underway = signal<Drawing | null>(null);

/** The radius of the eraser, in units of the sheet. */
const ERASER = 18;

let stroke: Stroke = { points: [] };

export const isDown = () => underway.value !== null;

export function down(at: Point, pressure: number) {
  stroke = { points: [[...at, pressure]] };
  underway.value = tool.value === "eraser" ? withoutTouched(drawing.value, at, at) : withStroke();
}

export function move(at: Point, pressure: number) {
  const last = stroke.points[stroke.points.length - 1];
  if (!underway.value || !last) return;
  if (tool.value === "eraser") {
    underway.value = withoutTouched(underway.value, [last[0], last[1]], at);
    stroke = { points: [[...at, pressure]] };
  } else {
    stroke = { points: extended(stroke.points, [...at, pressure], unit(drawing.value.frame)) };
    underway.value = withStroke();
  }
}

/** Lifts the pen: what was drawn is on the sheet. */
export function lift() {
  const next = underway.value;
  underway.value = null;
  const isChanged = next?.strokes.some((stroke, i) => stroke !== drawing.value.strokes[i]);
  if (next && (isChanged || next.strokes.length !== drawing.value.strokes.length)) edit(next);
}

/** Takes the edit under way back. */
export function abandon() {
  underway.value = null;
}

function withStroke(): Drawing {
  const { frame, strokes } = drawing.value;
  const drawn = symmetric.value ? [stroke, mirrored(stroke, frame)] : [stroke];
  return withStrokes(drawing.value, [...strokes, ...drawn]);
}

function withoutTouched(from: Drawing, a: Point, b: Point): Drawing {
  return withStrokes(from, erased(from.strokes, a, b, ERASER * unit(from.frame)));
}
