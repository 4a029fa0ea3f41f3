/** The surface in fewer triangles, for those who draw it many times a second without a graphics card. */
import type { Surface } from "./surface";

/**
 * About so many triangles that look like the surface from afar, of the same vertices: those in one cell of a grid are taken for the
 * first of them, and a triangle within fewer than three cells is left out.
 */
export function coarser({ positions, triangles, area }: Surface, wanted: number): Uint32Array {
  // A surface crosses about area / side² cells, and has two triangles for each.
  const side = Math.sqrt((2 * area) / wanted);
  const firsts = new Map<string, number>();
  const found = Uint32Array.from({ length: positions.length / 3 }, (_, v) => {
    const cell = [0, 1, 2].map((axis) => Math.floor((positions[3 * v + axis] as number) / side)).join();
    const known = firsts.get(cell);
    if (known === undefined) firsts.set(cell, v);
    return known ?? v;
  });
  const kept: number[] = [];
  for (let t = 0; t < triangles.length; t += 3) {
    const [a, b, c] = [0, 1, 2].map((corner) => found[triangles[t + corner] as number]) as [number, number, number];
    if (a !== b && b !== c && c !== a) kept.push(a, b, c);
  }
  return Uint32Array.from(kept);
}
