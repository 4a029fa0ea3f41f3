/** The mesh as the page needs it. */
import type { Geometry } from "../api/types";

export interface Surface {
  /** x, y, z of every vertex of the file. */
  positions: Float32Array;
  triangles: Uint32Array;
  /** Vertices that share an edge with a vertex: those of v at `starts[v]..starts[v + 1]`, one on two triangles twice. */
  starts: Uint32Array;
  neighbours: Uint32Array;
  /** The first vertex at the place of each vertex: files repeat vertices along seams. */
  first: Uint32Array;
  area: number;
}

/** Places nearer than this share of the longest side of the box are one. */
const SAME = 1e-6;

export function surfaceOf(geometry: Geometry): Surface {
  const positions = Float32Array.from(geometry.vertices.flatMap(([x, y, z]) => [x ?? 0, y ?? 0, z ?? 0]));
  const triangles = Uint32Array.from(geometry.triangles.flat());
  const first = firsts(positions, triangles);
  return { positions, triangles, first, ...edges(first, triangles), area: area(positions, triangles) };
}

function firsts(positions: Float32Array, triangles: Uint32Array): Uint32Array {
  const step = SAME * Math.max(...sidesOfBox(positions, triangles));
  const seen = new Map<string, number>();
  return Uint32Array.from({ length: positions.length / 3 }, (_, v) => {
    const key = [0, 1, 2].map((i) => Math.round(positions[3 * v + i] / step)).join();
    const known = seen.get(key);
    if (known === undefined) seen.set(key, v);
    return known ?? v;
  });
}

function sidesOfBox(positions: Float32Array, triangles: Uint32Array): number[] {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (const v of triangles) {
    for (let i = 0; i < 3; i++) {
      const x = positions[3 * v + i];
      low[i] = Math.min(low[i], x);
      high[i] = Math.max(high[i], x);
    }
  }
  return high.map((x, i) => x - low[i]);
}

function edges(first: Uint32Array, triangles: Uint32Array) {
  const starts = new Uint32Array(first.length + 1);
  const sides = function* () {
    for (let t = 0; t < triangles.length; t += 3) {
      const a = first[triangles[t] as number];
      const b = first[triangles[t + 1] as number];
      const c = first[triangles[t + 2] as number];
      yield [a, b] as const;
      yield [b, c] as const;
      yield [c, a] as const;
    }
  };
  for (const [a, b] of sides()) {
    starts[a + 1]++;
    starts[b + 1]++;
  }
  for (let v = 1; v < starts.length; v++) starts[v] = starts[v] + starts[v - 1];
  const neighbours = new Uint32Array(starts[starts.length - 1]);
  const next = starts.slice();
  for (const [a, b] of sides()) {
    neighbours[next[a]++] = b;
    neighbours[next[b]++] = a;
  }
  return { starts, neighbours };
}

function area(positions: Float32Array, triangles: Uint32Array): number {
  let sum = 0;
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [0, 1, 2].map((i) => 3 * triangles[t + i]) as [number, number, number];
    const side = (from: number, to: number) =>
      [0, 1, 2].map((i) => positions[to + i] - positions[from + i]) as [number, number, number];
    const [p, q] = [side(a, b), side(a, c)];
    sum += Math.hypot(p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]) / 2;
  }
  return sum;
}

export function edgeLength({ positions }: Surface, v: number, w: number): number {
  return Math.hypot(
    positions[3 * v] - positions[3 * w],
    positions[3 * v + 1] - positions[3 * w + 1],
    positions[3 * v + 2] - positions[3 * w + 2],
  );
}
