/** The state of the page, kept in the browser over a reload. */
import { effect } from "@preact/signals";
import { get, set } from "idb-keyval";
import type { MatchRequest, Ups } from "../api/types";
import type { Drawing } from "../drawing/drawing";
import { components, type Landmark, landmarks, type Part, part, settings, up } from "./corrections";
import { drawing, figure } from "./drawing";
import { mesh } from "./mesh";

export interface Kept {
  drawing: Drawing;
  figure: number;
  mesh: { id: string; name: string } | null;
  landmarks: Landmark[];
  up: Ups;
  part: Part | null;
  components: number[] | null;
  settings: Partial<MatchRequest>;
}

const KEY = "state";

export function now(): Kept {
  const document = mesh.value?.document;
  return {
    drawing: drawing.value,
    figure: figure.value,
    mesh: document ? { id: document.id, name: document.name ?? "" } : null,
    landmarks: landmarks.value,
    up: up.value,
    part: part.value,
    components: components.value,
    settings: settings.value,
  };
}

/** Sets everything but the mesh, which has to be fetched. */
export function restore(kept: Kept) {
  drawing.value = kept.drawing;
  figure.value = kept.figure;
  landmarks.value = kept.landmarks;
  up.value = kept.up;
  part.value = kept.part;
  components.value = kept.components;
  settings.value = kept.settings;
}

/** What was kept; nothing where the browser keeps nothing for this page. */
export const kept = (): Promise<Kept | undefined> => get<Kept>(KEY).catch(() => undefined);

/** Keeps every change from now on. */
export function keep() {
  effect(() => {
    const state = now();
    set(KEY, state).catch(() => {});
  });
}
