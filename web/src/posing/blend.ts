/** The mesh and the drawing as their handles take them: the server's basis of the handles, blended at every move. */
import { computed, effect, signal } from "@preact/signals";
import * as poses from "../api/poses";
import { words } from "../api/trouble";
import { isYUp } from "../drawing/drawing";
import { affine, type Handle, type Move, movedDrawing, movedMesh, requested, STAY } from "../geometry/handles";
import { handles } from "../state/handles";
import { type Answer, finalAnswer } from "../state/live";
import { posed } from "../state/posed";
import { shown } from "./playing";
import { taken } from "./taken";

/** Handles with what they do to a match. */
interface Held {
  handles: Handle[];
  answer: Answer;
  basis: poses.Basis;
  /** By rows: points of the drawing × handles. */
  weights: Float64Array;
  /** Where the places of the mesh are written. */
  positions: Float32Array;
}

/** How long the handles may be followed by another before the server is asked what they do, in ms. */
const PAUSE = 200;

const fetched = signal<Held | null>(null);
/** Why the handles do nothing, in words. */
export const unheld = signal<string | null>(null);

/** What is known of the handles of now. */
export const held = computed(() => {
  const now = fetched.value;
  return now?.handles === handles.value && now.answer === finalAnswer.value ? now : null;
});

/** Asks what the handles do whenever they change, and keeps what is shown in their pose; until the end is called. */
export function blend(): () => void {
  const ends = [effect(ask), effect(show)];
  return () => {
    for (const end of ends) end();
    posed.value = null;
  };
}

function ask() {
  const [answer, set] = [finalAnswer.value, handles.value];
  unheld.value = null;
  if (!answer || set.length === 0) return;
  const stop = new AbortController();
  const timer = setTimeout(() => {
    basisOf(set, answer, stop.signal).then(
      (found) => {
        fetched.value = found;
      },
      (error) => {
        if (!stop.signal.aborted) unheld.value = words(error);
      },
    );
  }, PAUSE);
  return () => {
    clearTimeout(timer);
    stop.abort();
  };
}

function basisOf(set: Handle[], answer: Answer, signal: AbortSignal): Promise<Held> {
  const yUp = isYUp(answer.reading.of);
  const request = { match: answer.match.id, ...requested(set, [set.map(() => STAY)], yUp) };
  return poses.during(request, signal, async ({ id }) => {
    const [basis, { weights }] = await Promise.all([poses.basis(id, signal), poses.result(id, signal)]);
    return {
      handles: set,
      answer,
      basis,
      weights: Float64Array.from(weights?.values.flat() ?? []),
      positions: new Float32Array(basis.rest.length),
    };
  });
}

function show() {
  if (taken.value) posed.value = { positions: taken.value.positions, drawing: null };
  else posed.value = held.value && moved(held.value, shown.value);
}

function moved({ handles, answer, basis, weights, positions }: Held, moves: Move[]) {
  const { of, flat } = answer.reading;
  const maps = handles.map((handle, i) => affine(handle, moves[i] ?? STAY));
  movedMesh(basis, maps, isYUp(of), positions);
  return { positions, drawing: movedDrawing(flat.points, weights, maps) };
}
