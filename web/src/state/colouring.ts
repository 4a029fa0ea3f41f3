/** The colours of both sides: those of the places that correspond, of regions, or of a function on each. */
import { computed, signal } from "@preact/signals";
import { believed, label, PLAIN, place, signed } from "../colour/maps";
import { bytes, type Lab, light, mixed } from "../colour/oklab";
import { type Spread, spread } from "../geometry/spread";
import type { Surface } from "../geometry/surface";
import { type Answer, answer, chosen } from "./live";
import { mesh } from "./mesh";
import { palette } from "./preferences";

/** What the colours tell. */
export type Coloured =
  | { by: "places" | "regions" }
  /** A value for every vertex of both shapes. */
  | { by: "values"; sketch: Float64Array; mesh: Float64Array };

export const coloured = signal<Coloured>({ by: "places" });

/** The vertices of the mesh that are answered: those of the chosen alternative, else of the answer. */
export const vertices = computed((): number[] => {
  if (!answer.value) return [];
  const { result } = answer.value;
  const alternative = chosen.value === null ? null : result.alternatives[chosen.value];
  return alternative?.mesh_vertices ?? result.correspondences.map((point) => point.mesh_vertex);
});

/** Where the answers lie on the mesh, and which is nearest to every vertex. */
export const spreading = computed((): Spread | null =>
  answer.value ? spread(answer.value.mesh.surface, vertices.value) : null,
);

/** The sketch's vertex that a vertex of the mesh answers; of several the first. */
export const answeredBy = computed(() => {
  const first = answer.value?.mesh.surface.first;
  const by = new Map<number, number>();
  vertices.value.forEach((vertex, x) => {
    const v = first?.[vertex] ?? vertex;
    if (!by.has(v)) by.set(v, x);
  });
  return by;
});

/** Red, green and blue of every vertex of the sketch, 0 to 255. */
export const sketchColours = computed((): Uint8Array | null => {
  const now = answer.value;
  if (!now) return null;
  return Uint8Array.from(labsOfSketch(now).flatMap(bytes));
});

/** The light of every vertex of the mesh: linear red, green and blue. */
export const meshColours = computed((): Float32Array | null => {
  const now = answer.value;
  const surface = mesh.value?.surface;
  if (!surface) return null;
  if (!now || now.mesh.surface !== surface) return plain(surface);
  return Float32Array.from(labsOfMesh(now).flatMap(light));
});

function plain({ first }: Surface): Float32Array {
  const colour = light(PLAIN);
  return Float32Array.from({ length: 3 * first.length }, (_, i) => colour[i % 3]);
}

function labsOfSketch(now: Answer): Lab[] {
  const { by } = coloured.value;
  if (coloured.value.by === "values") return ofValues(coloured.value.sketch);
  return by === "regions" ? now.result.intermediate.regions.sketch.map(label) : places.value;
}

function labsOfMesh(now: Answer): Lab[] {
  const { by } = coloured.value;
  if (coloured.value.by === "values") return ofValues(coloured.value.mesh);
  return by === "regions" ? now.result.intermediate.regions.mesh.map(label) : carriedOver(now);
}

function ofValues(values: Float64Array): Lab[] {
  const largest = values.reduce((most, value) => (Number.isNaN(value) ? most : Math.max(most, Math.abs(value))), 0);
  return Array.from(values, (value) => signed(value / (largest || 1)));
}

/** How far the colours at first sight are faded. */
const PROVISIONAL = 0.3;

/** The colour of every vertex of the sketch by its place in the box, as far as it is believed. */
const places = computed((): Lab[] => {
  if (!answer.value) return [];
  const { reading, result } = answer.value;
  const { points, box } = reading.flat;
  return result.correspondences.map(({ confidence }, x) => {
    const across = (points[2 * x] - box.x) / (box.width || 1);
    // y is down on the sheet; the lightness is highest at the top.
    const upward = 1 - (points[2 * x + 1] - box.y) / (box.height || 1);
    const [along, beside] = box.width >= box.height ? [across, upward] : [upward, across];
    const colour = believed(place(palette.value, along, beside), confidence);
    return result.preview ? mixed(colour, PLAIN, PROVISIONAL) : colour;
  });
});

/** The share of the reach from which colours fade. */
const FADING = 0.6;
/** Rounds in which the seams between the colours of two answers are softened. */
const SOFTENING = 6;

/** The colours of the sketch on the mesh, as the server's pictures have them. */
function carriedOver(now: Answer): Lab[] {
  const { surface } = now.mesh;
  const { distances, source, reach } = spreading.value as Spread;
  const means = meansOfAnswers(places.value, surface);
  const reached = Array.from(distances.keys()).filter((v) => distances[v] < Infinity);
  const labs: Lab[] = Array.from(source, (vertex) => means.get(vertex) ?? PLAIN);
  for (let round = 0; round < SOFTENING; round++) soften(labs, surface, distances, reached);
  const faded = labs.map((lab, v) => {
    const fade = (distances[v] / reach - FADING) / (1 - FADING);
    return mixed(lab, PLAIN, Math.min(1, Math.max(0, fade)));
  });
  return faded.map((_, v) => faded[surface.first[v] as number] as Lab);
}

/** For every vertex of the mesh that is answered the mean of the colours of those that answer it. */
function meansOfAnswers(labs: Lab[], { first }: Surface): Map<number, Lab> {
  const means = new Map<number, Lab>();
  const counts = new Map<number, number>();
  vertices.value.forEach((vertex, x) => {
    const v = first[vertex];
    const count = (counts.get(v) ?? 0) + 1;
    counts.set(v, count);
    const lab = labs[x] as Lab;
    means.set(v, mixed(means.get(v) ?? lab, lab, 1 / count));
  });
  return means;
}

/** Takes the vertices between answers to the mean of themselves and their neighbours; answers stay. */
function soften(labs: Lab[], { starts, neighbours }: Surface, distances: Float64Array, reached: number[]) {
  const before = labs.slice();
  for (const v of reached) {
    if (distances[v] === 0) continue;
    let [l, a, b] = before[v] as Lab;
    let count = 1;
    for (let i = starts[v]; i < starts[v + 1]; i++) {
      const w = neighbours[i];
      if (distances[w] === Infinity) continue;
      const lab = before[w] as Lab;
      l += lab[0];
      a += lab[1];
      b += lab[2];
      count++;
    }
    labs[v] = [l / count, a / count, b / count];
  }
}
