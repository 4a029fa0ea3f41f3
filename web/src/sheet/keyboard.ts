/** Drawing and placing by keys: arrows move a cross, Space or Enter puts the pen down and lifts it. */
import { signal } from "@preact/signals";
import { unit } from "../drawing/drawing";
import type { Point } from "../geometry/flat";
import { place } from "../state/corrections";
import { drawing } from "../state/drawing";
import { addPoint, isPlacing } from "../state/handles";
import { hovered } from "../state/hover";
import { tool } from "../state/tools";
import * as pencil from "./pencil";

/** Where the cross is; nothing while the pointer is used. */
export const cursor = signal<Point | null>(null);

/** How far an arrow moves the cross, in units of the sheet; with Shift a tenth. */
const STEP = 20;

const DIRECTIONS: Record<string, Point> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, -1],
  ArrowDown: [0, 1],
};

export function onKey(event: KeyboardEvent) {
  const direction = DIRECTIONS[event.key];
  const isPress = event.key === " " || event.key === "Enter";
  if (event.ctrlKey || event.metaKey || event.altKey || !(direction || isPress || event.key === "Escape")) return;
  event.preventDefault();
  if (direction) return step(direction, event.shiftKey ? STEP / 10 : STEP);
  if (event.key === "Escape") return pencil.abandon();
  press();
}

function step([dx, dy]: Point, units: number) {
  const { frame } = drawing.value;
  const [x, y] = cursor.value ?? [frame.x + frame.width / 2, frame.y + frame.height / 2];
  const way = units * unit(frame);
  const inside = (value: number, low: number, side: number) => Math.min(low + side, Math.max(low, value));
  const at: Point = [inside(x + dx * way, frame.x, frame.width), inside(y + dy * way, frame.y, frame.height)];
  cursor.value = at;
  hovered.value = { at };
  pencil.move(at, 0.5);
}

function press() {
  if (!cursor.value) return step([0, 0], 0);
  if (tool.value === "landmark") place({ at: cursor.value });
  else if (tool.value === "pose") isPlacing.value && addPoint(cursor.value);
  else if (pencil.isDown()) pencil.lift();
  else pencil.down(cursor.value, 0.5);
}
