/** What is known at some vertices of a surface, carried over to those around. */
import { edgeLength, type Surface } from "./surface";

/** How far along the surface an answer spreads, in units of √area, as in the server's pictures. */
const REACH = 0.12;

export interface Spread {
  /** For every vertex the length of the shortest path along edges from a source, infinite beyond the reach. */
  distances: Float64Array;
  /** The source it is from; −1 beyond the reach. */
  source: Int32Array;
  reach: number;
}

/** The nearest of `sources` for every vertex within reach (Dijkstra). */
export function spread(surface: Surface, sources: Iterable<number>): Spread {
  const { first, starts, neighbours } = surface;
  const reach = REACH * Math.sqrt(surface.area);
  const distances = new Float64Array(first.length).fill(Infinity);
  const source = new Int32Array(first.length).fill(-1);
  const front = new Heap();
  for (const answered of sources) {
    const v = first[answered];
    if (distances[v] === 0) continue;
    distances[v] = 0;
    source[v] = v;
    front.push(0, v);
  }
  for (let next = front.pop(); next; next = front.pop()) {
    const [distance, v] = next;
    if (distance > distances[v]) continue;
    for (let i = starts[v]; i < starts[v + 1]; i++) {
      const w = neighbours[i];
      const farther = distance + edgeLength(surface, v, w);
      if (farther <= reach && farther < distances[w]) {
        distances[w] = farther;
        source[w] = source[v];
        front.push(farther, w);
      }
    }
  }
  return { distances, source, reach };
}

/** A binary heap of vertices by distance. */
class Heap {
  private readonly keys: number[] = [];
  private readonly vertices: number[] = [];

  push(key: number, vertex: number) {
    let i = this.keys.length;
    while (i > 0) {
      const parent = (i - 1) >> 1;
      if (this.keys[parent] <= key) break;
      this.move(parent, i);
      i = parent;
    }
    this.keys[i] = key;
    this.vertices[i] = vertex;
  }

  pop(): [number, number] | null {
    const top = this.keys[0];
    if (top === undefined) return null;
    const popped: [number, number] = [top, this.vertices[0] as number];
    const key = this.keys.pop() as number;
    const vertex = this.vertices.pop() as number;
    const length = this.keys.length;
    if (length === 0) return popped;
    let i = 0;
    for (;;) {
      let child = 2 * i + 1;
      if (child >= length) break;
      if (child + 1 < length && this.keys[child + 1] < this.keys[child]) child++;
      if (this.keys[child] >= key) break;
      this.move(child, i);
      i = child;
    }
    this.keys[i] = key;
    this.vertices[i] = vertex;
    return popped;
  }

  private move(from: number, to: number) {
    this.keys[to] = this.keys[from];
    this.vertices[to] = this.vertices[from];
  }
}
