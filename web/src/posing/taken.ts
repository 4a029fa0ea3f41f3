/** The pose that a drawing shows, taken by the mesh. */
import { effect, signal } from "@preact/signals";
import { failure, follow } from "../api/jobs";
import * as matches from "../api/matches";
import * as poses from "../api/poses";
import * as shapes from "../api/shapes";
import { words } from "../api/trouble";
import type { PoseRequest } from "../api/types";
import { drawingOf } from "../drawing/files";
import { fileOf } from "../drawing/upload";
import { type Answer, finalAnswer } from "../state/live";
import { madeMatch, madeSketch } from "../state/tidy";

export interface Taken {
  name: string;
  request: PoseRequest;
  positions: Float32Array;
}

export const taken = signal<Taken | null>(null);
/** The name of the drawing whose pose is being taken, or why it was not. */
export const taking = signal<{ from: string } | { refused: string } | null>(null);

let running = new AbortController();

/** Lets the mesh stand again as its handles have it. */
export function giveBack() {
  running.abort();
  taken.value = null;
  taking.value = null;
}

/** Gives a pose of another answer back, until the end is called. */
export const followAnswer = () =>
  effect(() => {
    finalAnswer.value;
    return giveBack;
  });

/** The pose of the drawing that is matched. */
export const takeOwn = (answer: Answer) =>
  take("the drawing", async () => ({ match: answer.match.id, sketch: answer.reading.document.id }));

/** The pose of a drawing in a file, which is matched to the same mesh first. */
export const takeOther = (answer: Answer, file: File) =>
  take(file.name, async (signal) => {
    const drawing = await drawingOf(file);
    const { document, isNew } = await shapes.uploadSketch(await fileOf(drawing), 0, signal);
    if (isNew) madeSketch(document.id);
    const started = await matches.create({ mesh: answer.mesh.document.id, sketch: document.id });
    madeMatch(started.id);
    const ended = await follow(started, () => {}, signal);
    if (ended.status !== "succeeded") throw failure(ended);
    return { match: ended.id, sketch: document.id };
  });

async function take(from: string, asked: (signal: AbortSignal) => Promise<PoseRequest>) {
  giveBack();
  running = new AbortController();
  const { signal } = running;
  taking.value = { from };
  try {
    const request = await asked(signal);
    const result = await poses.during(request, signal, ({ id }) => poses.result(id, signal));
    signal.throwIfAborted();
    const positions = Float32Array.from(
      (result.frames[0]?.positions ?? []).flatMap((place) => place.map((x) => x ?? 0)),
    );
    taken.value = { name: from, request, positions };
    taking.value = null;
  } catch (error) {
    if (signal.aborted) return;
    taking.value = { refused: error instanceof Error && error.constructor === Error ? error.message : words(error) };
  }
}
