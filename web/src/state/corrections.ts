/** What the user says about the match: landmarks, which way is up, what part, which components. */
import { signal } from "@preact/signals";
import type { MatchRequest, Ups } from "../api/types";
import type { Point } from "../geometry/flat";

export interface Landmark {
  id: number;
  /** Its place on the sheet and its vertex of the mesh; one is missing until it is set. */
  at: Point | null;
  vertex: number | null;
}

export type Part = NonNullable<MatchRequest["part"]>;

export const landmarks = signal<Landmark[]>([]);
/** The directions said to be up, of the sketch in coordinates of the sheet. */
export const up = signal<Ups>({});
export const part = signal<Part | null>(null);
export const components = signal<number[] | null>(null);
/** Everything else a request may say, as it is sent. */
export const settings = signal<Partial<MatchRequest>>({});

/** Sets the missing side of the landmark that lacks it, or begins one. */
export function place(side: { at: Point } | { vertex: number }) {
  const lacking = landmarks.value.find((landmark) => ("at" in side ? landmark.at : landmark.vertex) === null);
  if (lacking) return move(lacking.id, side);
  const id = 1 + Math.max(0, ...landmarks.value.map((landmark) => landmark.id));
  landmarks.value = [...landmarks.value, { id, at: null, vertex: null, ...side }];
}

export function move(id: number, side: { at: Point } | { vertex: number }) {
  landmarks.value = landmarks.value.map((landmark) => (landmark.id === id ? { ...landmark, ...side } : landmark));
}

export function remove(id: number) {
  landmarks.value = landmarks.value.filter((landmark) => landmark.id !== id);
}

/** What was said of another mesh says nothing of this one. */
export function forgetCorrections() {
  landmarks.value = [];
  components.value = null;
  up.value = up.value.sketch ? { sketch: up.value.sketch } : {};
}
