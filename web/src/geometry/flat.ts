/** The triangulated drawing. */
import type { Geometry } from "../api/types";

export type Point = readonly [number, number];

export interface Flat {
  /** x and y of every vertex, in the coordinates of the sheet: y down. */
  points: Float64Array;
  triangles: Uint32Array;
  /** Closed lines around the figure and its holes. */
  outlines: Point[][];
  box: Box;
}

export interface Box {
  x: number;
  y: number;
  width: number;
  height: number;
}

/** The triangulation as it lies on the sheet; `yUp` where the upload's y points up. */
export function flatOf(geometry: Geometry, yUp: boolean): Flat {
  const points = Float64Array.from(geometry.vertices.flatMap(([x = 0, y = 0]) => [x, yUp ? -y : y]));
  const triangles = Uint32Array.from(geometry.triangles.flat());
  return { points, triangles, outlines: outlines(points, triangles), box: boxOf(points) };
}

export function pointOf(flat: Flat, vertex: number): Point {
  return [flat.points[2 * vertex], flat.points[2 * vertex + 1] as number];
}

export function boxOf(points: ArrayLike<number>): Box {
  let [left, top, right, bottom] = [Infinity, Infinity, -Infinity, -Infinity];
  for (let i = 0; i < points.length; i += 2) {
    const [x, y] = [points[i], points[i + 1] as number];
    left = Math.min(left, x);
    right = Math.max(right, x);
    top = Math.min(top, y);
    bottom = Math.max(bottom, y);
  }
  return { x: left, y: top, width: right - left, height: bottom - top };
}

/** The sides with one triangle, joined end to start. */
function outlines(points: Float64Array, triangles: Uint32Array): Point[][] {
  const sides = new Map<number, Set<number>>();
  const add = (from: number, to: number) => {
    const back = sides.get(to);
    if (back?.delete(from)) return;
    const out = sides.get(from);
    if (out) out.add(to);
    else sides.set(from, new Set([to]));
  };
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [triangles[t], triangles[t + 1], triangles[t + 2] as number];
    add(a, b);
    add(b, c);
    add(c, a);
  }
  const lines: Point[][] = [];
  for (const [start, out] of sides) {
    while (out.size > 0) {
      const line: Point[] = [];
      let vertex: number | undefined = start;
      while (vertex !== undefined) {
        line.push([points[2 * vertex], points[2 * vertex + 1] as number]);
        const on: Set<number> | undefined = sides.get(vertex);
        const next: number | undefined = on?.values().next().value;
        if (next !== undefined) on?.delete(next);
        vertex = next === start ? undefined : next;
      }
      lines.push(line);
    }
  }
  return lines;
}

/** The vertex nearest to a point, and how far it is. */
export function nearestVertex(flat: Flat, [x, y]: Point): { vertex: number; distance: number } {
  let [vertex, least] = [0, Infinity];
  for (let v = 0; 2 * v < flat.points.length; v++) {
    const square = (flat.points[2 * v] - x) ** 2 + (flat.points[2 * v + 1] - y) ** 2;
    if (square < least) [vertex, least] = [v, square];
  }
  return { vertex, distance: Math.sqrt(least) };
}
