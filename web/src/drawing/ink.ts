/** Strokes as they are seen: the outline of the ink as a path of SVG. */
import { getStroke } from "perfect-freehand";
import type { Stroke } from "./drawing";

/** The width of the pen at a pressure of a half, in units of the sheet. */
export const WIDTH = 9;

/** The path of a stroke, `unit` being that of its sheet. */
export function inkPath(stroke: Stroke, unit: number): string {
  const options = { size: WIDTH * unit, thinning: 0.5, smoothing: 0.5, streamline: 0.35, simulatePressure: false };
  const rim = getStroke(stroke.points, { ...options, last: true });
  // Through the middles of the sides, so that the rim is smooth.
  const middles = rim.map(([x, y], i) => {
    const next = rim[(i + 1) % rim.length];
    return `${round(x)} ${round(y)} ${round((x + next[0]) / 2)} ${round((y + next[1]) / 2)}`;
  });
  const start = rim[0];
  return start ? `M${round(start[0])} ${round(start[1])}Q${middles.join(" ")}Z` : "";
}

const round = (x: number) => Math.round(100 * x) / 100;

/** A closed line as a path. */
export function linePath(line: readonly (readonly [number, number])[]): string {
  return `M${line.map(([x, y]) => `${round(x)} ${round(y)}`).join("L")}Z`;
}
