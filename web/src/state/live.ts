/** The match that follows the drawing: after every change it is asked for anew, and what runs is cancelled. */
import { batch, computed, effect, signal, untracked } from "@preact/signals";
import { failure, follow } from "../api/jobs";
import * as matches from "../api/matches";
import * as shapes from "../api/shapes";
import { Away, Refusal, words } from "../api/trouble";
import type { Match, ProblemFault, Result, SketchDocument } from "../api/types";
import { type Drawing, isEmpty, isYUp } from "../drawing/drawing";
import { fileOf } from "../drawing/upload";
import { type Flat, flatOf } from "../geometry/flat";
import { drawing, figure } from "./drawing";
import { type Mesh, mesh } from "./mesh";
import { missingOf, takesLines } from "./openness";
import { type Wishes, wishes } from "./request";
import { madeMatch, madeSketch } from "./tidy";

/** What the server read of a drawing. */
export interface Reading {
  of: Drawing;
  figure: number;
  document: SketchDocument;
  flat: Flat;
}

export interface Answer {
  reading: Reading;
  mesh: Mesh;
  match: Match;
  /** That at first sight, with `preview`, as long as the match runs. */
  result: Result;
}

export type Stage =
  | { kind: "idle" | "reading" | "done" }
  | { kind: "waiting"; place: number }
  | { kind: "matching"; stage: string; fraction: number }
  /** The drawing is not one figure yet; `isTaken` where the server would match it as lines all the same. */
  | { kind: "open"; words: string; faults: ProblemFault[]; isTaken: boolean }
  | { kind: "refused"; words: string; faults: ProblemFault[] }
  /** Tried again at `until`, ms since 1970. */
  | { kind: "away"; words: string; until: number };

export const stage = signal<Stage>({ kind: "idle" });
export const reading = signal<Reading | null>(null);
export const answer = signal<Answer | null>(null);
/** The answer once its match has ended: what can be asked of the server by its match. */
export const finalAnswer = computed(() => (answer.value?.result.preview ? null : answer.value));
/** The alternative that is shown instead of the answer, by its number. */
export const chosen = signal<number | null>(null);

/** How long a change of the settings may be followed by another before a match is asked for, in ms. */
const PAUSE = 250;
/** The stage of a match at which its answer at first sight is there. */
const PREVIEW = "preview";
/** Rests between tries while the server is away, in ms: doubled each time. */
const REST = { first: 1000, longest: 15_000 };

let running = new AbortController();
let rest = REST.first;

/** Follows the drawing, the mesh and the wishes from now on. */
export function live() {
  let before: [Drawing, Mesh | null] | null = null;
  effect(() => {
    const asked = { drawing: drawing.value, figure: figure.value, mesh: mesh.value, wishes: wishes.value };
    const isDrawn = before?.[0] !== asked.drawing || before[1] !== asked.mesh;
    before = [asked.drawing, asked.mesh];
    untracked(() => ask(asked, isDrawn ? 0 : PAUSE));
  });
  addEventListener("online", again);
}

/** Matches lines that enclose nothing, too. */
export function takeLines() {
  takesLines.value = true;
  again();
}

/** Asks once more for what is wanted now. */
export function again() {
  ask({ drawing: drawing.value, figure: figure.value, mesh: mesh.value, wishes: wishes.value }, 0);
}

interface Asked {
  drawing: Drawing;
  figure: number;
  mesh: Mesh | null;
  wishes: Wishes;
}

function ask(asked: Asked, pause: number) {
  running.abort();
  running = new AbortController();
  const { signal } = running;
  if (isEmpty(asked.drawing)) {
    reading.value = null;
    show(null);
    takesLines.value = false;
    stage.value = { kind: "idle" };
    return;
  }
  // An answer on another mesh or to another file says nothing of this one.
  if (answer.value?.mesh !== asked.mesh || answer.value?.reading.of.ground !== asked.drawing.ground) show(null);
  if (pause === 0) return void run(asked, signal);
  const timer = setTimeout(() => run(asked, signal), pause);
  signal.addEventListener("abort", () => clearTimeout(timer), { once: true });
}

/** Shows an answer, or none, without an alternative. */
function show(next: Answer | null) {
  batch(() => {
    answer.value = next;
    chosen.value = null;
  });
}

async function run(asked: Asked, signal: AbortSignal, isRetry = false) {
  try {
    const { document, read } = await readingOf(asked, signal);
    const missing = missingOf(asked.drawing, document);
    if (missing && !takesLines.value) {
      await read;
      stage.value = { kind: "open", words: missing, faults: [], isTaken: true };
    } else if (asked.mesh) {
      // The triangles of the drawing are fetched while it is matched.
      show(await matched(document, read, asked.mesh, asked.wishes, signal));
      stage.value = { kind: "done" };
      rest = REST.first;
    } else {
      await read;
      stage.value = { kind: "idle" };
    }
  } catch (error) {
    if (signal.aborted) return;
    // A sketch that was known before may have been deleted since: it is brought anew, once.
    if (error instanceof Refusal && error.status === 404 && reading.value && !isRetry) {
      reading.value = null;
      await run(asked, signal, true);
    } else {
      stage.value = trouble(error, signal);
    }
  }
}

/** What the server reads of the drawing, and where it lies once that is here; nothing is sent where it is known already. */
async function readingOf(asked: Asked, signal: AbortSignal) {
  const known = reading.value;
  if (known && known.of === asked.drawing && known.figure === asked.figure) {
    return { document: known.document, read: Promise.resolve(known) };
  }
  stage.value = { kind: "reading" };
  const document = await stored(asked, signal);
  signal.throwIfAborted();
  const read = located(asked, document, signal);
  // Whoever waits for it is told; where the match fails first, nobody does.
  read.catch(() => {});
  return { document, read };
}

async function located({ drawing, figure }: Asked, document: SketchDocument, signal: AbortSignal): Promise<Reading> {
  const flat = flatOf(await shapes.sketchGeometry(document.id), isYUp(drawing));
  signal.throwIfAborted();
  reading.value = { of: drawing, figure, document, flat };
  return reading.value;
}

async function stored({ drawing, figure }: Asked, signal: AbortSignal): Promise<SketchDocument> {
  const { ground, strokes } = drawing;
  if (ground?.kind === "stored" && strokes.length === 0) return shapes.sketch(ground.id);
  try {
    const { document, isNew } = await shapes.uploadSketch(await fileOf(drawing), figure, signal);
    if (isNew) madeSketch(document.id);
    return document;
  } catch (error) {
    throw error instanceof Refusal && error.status === 422 ? new Unread(error) : error;
  }
}

/** The drawing itself was refused. */
class Unread extends Error {
  constructor(readonly refusal: Refusal) {
    super(refusal.message);
  }
}

/** The answer of a match, which is shown at first sight before. */
async function matched(
  sketch: SketchDocument,
  read: Promise<Reading>,
  mesh: Mesh,
  wishes: Wishes,
  signal: AbortSignal,
): Promise<Answer> {
  stage.value = { kind: "matching", stage: "", fraction: 0 };
  // Not aborted with the rest: only what has been answered has an id to be cancelled by.
  const started = await matches.create({ ...wishes, mesh: mesh.document.id, sketch: sketch.id });
  madeMatch(started.id);
  const giveUp = () => void matches.cancel(started.id).catch(() => {});
  if (signal.aborted) giveUp();
  signal.throwIfAborted();
  signal.addEventListener("abort", giveUp, { once: true });
  const glance = new AbortController();
  let isGlimpsed = false;
  const told = (match: Match) => {
    if (signal.aborted) return;
    seen(match);
    if (match.progress.stage !== PREVIEW || isGlimpsed) return;
    isGlimpsed = true;
    // Where it cannot be had the answer itself is waited for.
    glimpse(match, read, mesh, AbortSignal.any([signal, glance.signal])).catch(() => {});
  };
  const ended = await follow(started, told, signal).finally(() => glance.abort());
  if (ended.status !== "succeeded") throw failure(ended);
  const [reading, result] = await Promise.all([read, matches.result(ended.id, signal)]);
  signal.throwIfAborted();
  signal.removeEventListener("abort", giveUp);
  return { reading, mesh, match: ended, result };
}

/** Shows the answer at first sight. */
async function glimpse(match: Match, read: Promise<Reading>, mesh: Mesh, signal: AbortSignal) {
  const [reading, result] = await Promise.all([read, matches.preview(match.id, signal)]);
  if (!signal.aborted) show({ reading, mesh, match, result });
}

function seen(match: Match) {
  if (match.status === "queued") stage.value = { kind: "waiting", place: match.place_in_queue ?? 1 };
  if (match.status === "running") {
    stage.value = { kind: "matching", stage: match.progress.stage ?? "", fraction: match.progress.fraction };
  }
}

/** What is said of a failure; where it passes, all is asked for again after a rest. */
function trouble(error: unknown, signal: AbortSignal): Stage {
  if (error instanceof Unread)
    return { kind: "open", words: words(error.refusal), faults: error.refusal.faults, isTaken: false };
  const passes = error instanceof Away || (error instanceof Refusal && error.passes);
  if (!passes) return { kind: "refused", words: words(error), faults: error instanceof Refusal ? error.faults : [] };
  const wait = Math.max(rest, error instanceof Refusal ? 1000 * (error.retryAfter ?? 0) : 0);
  rest = Math.min(2 * rest, REST.longest);
  const timer = setTimeout(again, wait);
  signal.addEventListener("abort", () => clearTimeout(timer), { once: true });
  return { kind: "away", words: words(error, true), until: Date.now() + wait };
}
