/** The point that is looked at, on both sides. */
import { computed, signal } from "@preact/signals";
import type { Point } from "../geometry/flat";
import { nearestVertex, pointOf } from "../geometry/flat";
import { answeredBy, spreading, vertices } from "./colouring";
import { answer } from "./live";
import { tool } from "./tools";

/** What the pointer is over: a place of the sheet or a vertex of the mesh. */
export const hovered = signal<{ at: Point } | { vertex: number } | null>(null);

/** How far from the figure the pointer may be, as a share of its longer side. */
const NEAR = 0.03;

export interface Twin {
  at: Point;
  vertex: number;
  confidence: number;
}

/** The point of the sketch and the vertex of the mesh that correspond there. */
export const twin = computed((): Twin | null => {
  const now = answer.value;
  if (!hovered.value || !now || tool.value === "pose") return null;
  const x = "at" in hovered.value ? ofPlace(hovered.value.at) : ofVertex(hovered.value.vertex);
  const vertex = x === null ? undefined : vertices.value[x];
  if (x === null || vertex === undefined) return null;
  const confidence = now.result.correspondences[x]?.confidence ?? 0;
  return { at: pointOf(now.reading.flat, x), vertex, confidence };
});

function ofPlace(at: Point): number | null {
  const flat = answer.value?.reading.flat;
  if (!flat) return null;
  const { vertex, distance } = nearestVertex(flat, at);
  return distance <= NEAR * Math.max(flat.box.width, flat.box.height) ? vertex : null;
}

function ofVertex(vertex: number): number | null {
  const surface = answer.value?.mesh.surface;
  const source = surface && spreading.value?.source[surface.first[vertex] ?? vertex];
  return source === undefined || source < 0 ? null : (answeredBy.value.get(source) ?? null);
}
