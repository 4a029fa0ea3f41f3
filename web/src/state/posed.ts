/** The pose that is shown; nothing while the mesh is at rest. */
import { signal } from "@preact/signals";

export interface Posed {
  /** x, y, z of every vertex of the mesh. */
  positions: Float32Array;
  /** x and y of every point of the drawing, where it moves too. */
  drawing: Float64Array | null;
}

export const posed = signal<Posed | null>(null);
