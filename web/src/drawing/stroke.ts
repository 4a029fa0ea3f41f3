/** Strokes while they are drawn and erased. */
import type { Point } from "../geometry/flat";
import type { Stroke } from "./drawing";

type Sample = Stroke["points"][number];

/** The longest way between two points of a stroke, in units of the sheet, so that an eraser cuts it where it passes. */
const STEP = 6;

/** The samples with one more, and with those between where it is far off. */
export function extended(points: Sample[], [x, y, pressure]: Sample, unit: number): Sample[] {
  const last = points[points.length - 1];
  if (!last) return [[x, y, pressure]];
  const pieces = Math.ceil(Math.hypot(x - last[0], y - last[1]) / (STEP * unit));
  const between = Array.from({ length: pieces }, (_, i): Sample => {
    const share = (i + 1) / pieces;
    return [last[0] + share * (x - last[0]), last[1] + share * (y - last[1]), last[2] + share * (pressure - last[2])];
  });
  return points.concat(between);
}

/** What is left of the strokes where an eraser of this radius went from one point to another. */
export function erased(strokes: Stroke[], from: Point, to: Point, radius: number): Stroke[] {
  return strokes.flatMap((stroke) => {
    const isKept = stroke.points.map((point) => distanceToSegment(point, from, to) > radius);
    return isKept.every(Boolean) ? [stroke] : runs(stroke, isKept);
  });
}

function runs(stroke: Stroke, isKept: boolean[]): Stroke[] {
  const kept: Stroke[] = [];
  let run: Sample[] = [];
  stroke.points.forEach((point, i) => {
    if (isKept[i]) run.push(point);
    if ((!isKept[i] || i === stroke.points.length - 1) && run.length > 0) {
      // A single point is what an eraser left over, not a dot that was drawn.
      if (run.length > 1) kept.push({ points: run });
      run = [];
    }
  });
  return kept;
}

function distanceToSegment([x, y]: readonly number[], [ax, ay]: Point, [bx, by]: Point): number {
  const [dx, dy] = [bx - ax, by - ay];
  const square = dx * dx + dy * dy;
  const share = square === 0 ? 0 : Math.min(1, Math.max(0, ((x - ax) * dx + (y - ay) * dy) / square));
  return Math.hypot(x - ax - share * dx, y - ay - share * dy);
}

/** The length of all strokes together. */
export function lengthOf(strokes: Stroke[]): number {
  const lengths = strokes.flatMap(({ points }) =>
    points.slice(1).map(([x, y], i) => Math.hypot(x - (points[i]?.[0] ?? x), y - (points[i]?.[1] ?? y))),
  );
  return lengths.reduce((sum, length) => sum + length, 0);
}

/** Ends farther than this from every other line are loose, in units of the sheet. */
const NEAR = 30;

/** Whether two places of the sheet are near enough to be one when lines are closed. */
export const isNear = ([ax, ay]: Point, [bx, by]: Point, unit: number) => Math.hypot(bx - ax, by - ay) < NEAR * unit;

/** Straight strokes between loose ends, the nearest two first, until fewer than two are left. */
export function bridges(strokes: Stroke[], unit: number): Stroke[] {
  const ends = looseEnds(strokes, unit);
  const gaps = ends.flatMap(([ax, ay], a) =>
    ends.slice(0, a).map(([bx, by], b) => ({ a, b, length: Math.hypot(bx - ax, by - ay) })),
  );
  const joined = new Set<number>();
  return gaps
    .sort((one, other) => one.length - other.length)
    .flatMap(({ a, b, length }) => {
      // The ends of a dot are one place.
      if (length === 0 || joined.has(a) || joined.has(b)) return [];
      joined.add(a).add(b);
      const [from, to] = [ends[a] as Point, ends[b] as Point];
      return [{ points: extended([[...from, 0.5]], [...to, 0.5], unit) }];
    });
}

/** The ends of strokes that meet no line. */
export function looseEnds(strokes: Stroke[], unit: number): Point[] {
  const near = NEAR * unit;
  const meets = ([x, y]: Sample, stroke: Stroke, own: number | null) =>
    stroke.points.some(([px, py], i) => {
      // Along its own stroke an end is near whatever is drawn just before it.
      const apart = own === null ? Infinity : Math.abs(i - own) * STEP * unit;
      return apart > 3 * near && Math.hypot(px - x, py - y) < near;
    });
  return strokes.flatMap((stroke) =>
    [0, stroke.points.length - 1].flatMap((end): Point[] => {
      const point = stroke.points[end];
      if (!point || strokes.some((other) => meets(point, other, other === stroke ? end : null))) return [];
      return [[point[0], point[1]]];
    }),
  );
}
