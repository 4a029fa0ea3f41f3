/** Places of a drawing where it is well held. */
import { type Flat, type Point, pointOf } from "./flat";

/** One in the middle of the body, and the ends that stand farthest out. */
export function spots(flat: Flat, count: number): Point[] {
  const rim = flat.outlines.flat();
  const inner = Array.from({ length: flat.points.length / 2 }, (_, v) => pointOf(flat, v));
  const found = [farthest(inner, rim)];
  while (found.length < count) found.push(farthest(rim, found));
  return found;
}

/** That of `points` which is farthest from all of `others`; the first of equals. */
function farthest(points: Point[], others: Point[]): Point {
  const away = ([x, y]: Point) =>
    others.reduce((least, [u, v]) => Math.min(least, (u - x) ** 2 + (v - y) ** 2), Infinity);
  let [best, most] = [points[0] as Point, -1];
  for (const point of points) {
    const distance = away(point);
    if (distance > most) [best, most] = [point, distance];
  }
  return best;
}
