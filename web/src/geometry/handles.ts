/** Handles that a drawing is moved by, where they go, and what follows from it. All in coordinates of the sheet, y down. */
import type { Basis } from "../api/poses";
import type { PoseRequest } from "../api/types";
import type { Point } from "./flat";

/** Holds what is around a point, or around the line between two. */
export type Handle = { kind: "point"; at: Point } | { kind: "bone"; from: Point; to: Point };

/** Where a handle goes: turned about its pivot, in degrees counter-clockwise as the sheet is seen, and then shifted. */
export interface Move {
  degrees: number;
  by: Point;
}

export const STAY: Move = { degrees: 0, by: [0, 0] };

/** (x, y) goes to (a x + b y + c, d x + e y + f). */
type Affine = [a: number, b: number, c: number, d: number, e: number, f: number];

/** What a handle turns about. */
export const pivot = (handle: Handle): Point => (handle.kind === "point" ? handle.at : handle.from);

/** The map of a handle; y of the sheet is down, so that what is counter-clockwise turns x to −y. */
export function affine(handle: Handle, { degrees, by }: Move): Affine {
  const [x, y] = pivot(handle);
  const [cos, sin] = [Math.cos((degrees * Math.PI) / 180), Math.sin((degrees * Math.PI) / 180)];
  return [cos, sin, x - cos * x - sin * y + by[0], -sin, cos, y + sin * x - cos * y + by[1]];
}

export const applied = ([a, b, c, d, e, f]: Affine, [x, y]: Point): Point => [a * x + b * y + c, d * x + e * y + f];

/** The share of the way from one move to another. */
export function between(from: Move, to: Move, share: number): Move {
  const mixed = (a: number, b: number) => a + share * (b - a);
  return { degrees: mixed(from.degrees, to.degrees), by: [mixed(from.by[0], to.by[0]), mixed(from.by[1], to.by[1])] };
}

/** The drawing's points, moved by its handles: `weights` by rows, points × handles (eq. 5.1 of docs/method.md). */
export function movedDrawing(points: Float64Array, weights: Float64Array, maps: Affine[]): Float64Array {
  const moved = new Float64Array(points.length);
  for (let v = 0; 2 * v < points.length; v++) {
    maps.forEach((map, i) => {
      const weight = weights[v * maps.length + i];
      const [x, y] = applied(map, [points[2 * v], points[2 * v + 1] as number]);
      moved[2 * v] += weight * x;
      moved[2 * v + 1] += weight * y;
    });
  }
  return moved;
}

/** The places of the mesh's vertices, written into `moved`; `yUp` where the upload's y points up. */
export function movedMesh({ basis, rest, places, axes }: Basis, maps: Affine[], yUp: boolean, moved: Float32Array) {
  const sign = yUp ? -1 : 1;
  const width = 3 * maps.length;
  const across = Float64Array.from(maps.flatMap(([a, b, c]) => [a, sign * b, c]));
  const along = Float64Array.from(maps.flatMap(([, , , d, e, f]) => [sign * d, e, sign * f]));
  const [x0, x1, x2, y0, y1, y2] = axes as unknown as [number, number, number, number, number, number];
  for (let v = 0, row = 0; 3 * v < rest.length; v++) {
    let [x, y] = [-places[2 * v], -(places[2 * v + 1] as number)];
    for (let i = 0; i < width; i++, row++) {
      const share = basis[row] as number;
      x += share * across[i];
      y += share * along[i];
    }
    moved[3 * v] = rest[3 * v] + x * x0 + y * y0;
    moved[3 * v + 1] = rest[3 * v + 1] + x * x1 + y * y1;
    moved[3 * v + 2] = rest[3 * v + 2] + x * x2 + y * y2;
  }
}

/** Handles and frames as a request says them, in the coordinates of the upload. */
export function requested(handles: Handle[], frames: Move[][], yUp: boolean): Pick<PoseRequest, "handles" | "frames"> {
  const turned = ([x, y]: Point) => [x, yUp ? -y : y];
  return {
    handles: handles.map((handle) =>
      handle.kind === "point"
        ? { type: "point", at: turned(handle.at) }
        : { type: "bone", from: turned(handle.from), to: turned(handle.to) },
    ),
    frames: frames.map((moves) =>
      moves.map(({ degrees, by }) =>
        degrees === 0 && by[0] === 0 && by[1] === 0 ? { type: "stay" } : { type: "rotation", degrees, by: turned(by) },
      ),
    ),
  };
}
