/** The state of the page, kept in the browser over a reload. */
import { effect } from "@preact/signals";
import { get, set } from "idb-keyval";
import type { MatchRequest, Ups } from "../api/types";
import type { Drawing } from "../drawing/drawing";
import type { Handle, Move } from "../geometry/handles";
import { components, type Landmark, landmarks, type Part, part, settings, up } from "./corrections";
import { drawing, figure } from "./drawing";
import { frames, handles, setHandles } from "./handles";
import { chosen, finalAnswer } from "./live";
import { mesh } from "./mesh";
import { type Tool, tool } from "./tools";

export interface Kept {
  drawing: Drawing;
  figure: number;
  mesh: { id: string; name: string } | null;
  landmarks: Landmark[];
  up: Ups;
  part: Part | null;
  components: number[] | null;
  settings: Partial<MatchRequest>;
  /** The alternative that is shown instead of the answer, by its number. */
  chosen: number | null;
  tool: Tool;
  handles: Handle[];
  frames: Move[][];
}

/** Changes with the form of what is kept. */
const KEY = "state-1";

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
    chosen: chosen.value,
    tool: tool.value,
    handles: handles.value,
    frames: frames.value,
  };
}

/** Sets everything but the mesh, which has to be fetched; what is lacking stays as it is. */
export function restore(kept: Partial<Kept>) {
  drawing.value = kept.drawing ?? drawing.value;
  figure.value = kept.figure ?? figure.value;
  landmarks.value = kept.landmarks ?? landmarks.value;
  up.value = kept.up ?? up.value;
  part.value = kept.part ?? part.value;
  components.value = kept.components ?? components.value;
  settings.value = kept.settings ?? settings.value;
  tool.value = kept.tool ?? tool.value;
  if (kept.handles && kept.frames) setHandles(kept.handles, kept.frames);
  if (typeof kept.chosen === "number") choose(kept.chosen);
}

/** Takes an alternative once the drawing of now has its answer. */
function choose(number: number) {
  const of = drawing.value;
  effect(function (this: { dispose(): void }) {
    const now = finalAnswer.value;
    if (drawing.value === of && !now) return;
    if (now?.reading.of === of && number < now.result.alternatives.length) chosen.value = number;
    this.dispose();
  });
}

/** What was kept; nothing where the browser keeps nothing for this page. */
export const kept = (): Promise<Kept | undefined> => get<Kept>(KEY).catch(() => undefined);

/** Keeps every change from now on; an address that holds an earlier state holds it no longer. */
export function keep() {
  let isChange = false;
  effect(() => {
    const state = now();
    set(KEY, state).catch(() => {});
    if (isChange && location.hash) history.replaceState(null, "", location.pathname);
    isChange = true;
  });
}
