/** The answer once the drawing rests: what costs the server more is asked for then, and what was replaced is deleted. */
import { effect, signal } from "@preact/signals";
import { type Answer, answer } from "./live";
import { sweeper } from "./tidy";

/** How long an answer has to stand, in ms: a hand that draws on has begun the next stroke by then. */
const REST = 500;

export const rested = signal<Answer | null>(null);

/** Follows the answers from now on. */
export function followRest() {
  effect(() => {
    const now = answer.value;
    if (!now) {
      rested.value = null;
      return;
    }
    if (now.result.preview) return;
    const sweep = sweeper(now.match);
    const timer = setTimeout(() => {
      rested.value = now;
      void sweep();
    }, REST);
    return () => clearTimeout(timer);
  });
}
