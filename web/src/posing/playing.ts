/** The frames, one after the other and round again. */
import { computed, signal } from "@preact/signals";
import { between, type Move, STAY } from "../geometry/handles";
import { frames, moves } from "../state/handles";

/** The time from one frame to the next, in ms. */
const STEP = 600;

/** How far it is played, in frames; nothing while it stands still. */
const played = signal<number | null>(null);

export const isPlaying = computed(() => played.value !== null);

export function play() {
  const start = performance.now();
  played.value = 0;
  const step = (now: number) => {
    if (played.value === null) return;
    played.value = (Math.max(0, now - start) / STEP) % frames.value.length;
    requestAnimationFrame(step);
  };
  requestAnimationFrame(step);
}

export function pause() {
  played.value = null;
}

/** The moves that are seen: those of the frame, or between two while frames are played. */
export const shown = computed((): Move[] => {
  const at = played.value;
  if (at === null) return moves.value;
  const all = frames.value;
  const from = all[Math.floor(at)] ?? [];
  const to = all[(Math.floor(at) + 1) % all.length] ?? [];
  return from.map((move, i) => between(move, to[i] ?? STAY, at % 1));
});
