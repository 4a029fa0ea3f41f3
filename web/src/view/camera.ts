/** Where the camera is put: the view of the answer when it is a new one, and whenever it is asked for. */
import { effect, signal, untracked } from "@preact/signals";
import type { View } from "../api/types";
import { drawing } from "../state/drawing";
import { answer, chosen } from "../state/live";
import { type Mesh, mesh } from "../state/mesh";

/** The view to put the camera in; a new object each time it is to be put there. */
export const asDrawn = signal<{ view: View; isFlown: boolean } | null>(null);

/** The view that is shown: of the chosen alternative, else of the answer. */
function viewOfAnswer(): View | null {
  const result = answer.value?.result;
  if (!result || answer.value?.mesh !== mesh.value) return null;
  const alternative = chosen.value === null ? null : result.alternatives[chosen.value];
  return alternative?.view ?? result.alignment?.view ?? null;
}

export function lookAsDrawn() {
  const view = viewOfAnswer();
  if (view) asDrawn.value = { view, isFlown: true };
}

/** The cosine of the angle from which on two views are another: the camera is left alone between strokes. */
const SAME = 0.985;

/** How long an uncertain answer has to stand before the camera follows it, in ms. */
const SETTLED = 1200;

/** Follows the answers from now on. */
export function followViews() {
  let last: View | null = null;
  let of: Mesh | null = null;
  effect(() => {
    if (mesh.value && mesh.value !== of) {
      of = mesh.value;
      last = null;
      const view = startingView(mesh.value);
      untracked(() => {
        asDrawn.value = { view, isFlown: false };
      });
    }
    const view = viewOfAnswer();
    if (!view || (last && isSame(view, last))) return;
    const fly = () => {
      last = view;
      asDrawn.value = { view, isFlown: true };
    };
    if (answer.peek()?.result.rating !== "low" || chosen.value !== null) return fly();
    // Half a drawing fits anywhere: the camera waits whether more is drawn.
    drawing.value;
    const timer = setTimeout(fly, SETTLED);
    return () => clearTimeout(timer);
  });
}

function isSame(a: View, b: View): boolean {
  const cosine = (p: number[], q: number[]) => p.reduce((sum, x, i) => sum + x * (q[i] ?? 0), 0);
  return cosine(a.toward_camera, b.toward_camera) > SAME && cosine(a.up, b.up) > SAME;
}

/** From the front right and a little above, up being what the server takes for up. */
function startingView({ document }: Mesh): View {
  const up = document.up?.direction ?? [0, 1, 0];
  const beside = [up[1] ?? 0, up[2] ?? 0, up[0] ?? 0];
  const front = [
    (up[1] ?? 0) * (beside[2] ?? 0) - (up[2] ?? 0) * (beside[1] ?? 0),
    (up[2] ?? 0) * (beside[0] ?? 0) - (up[0] ?? 0) * (beside[2] ?? 0),
    (up[0] ?? 0) * (beside[1] ?? 0) - (up[1] ?? 0) * (beside[0] ?? 0),
  ];
  const toward = up.map((x, i) => 0.35 * x + 0.7 * (beside[i] ?? 0) - 0.6 * (front[i] ?? 0));
  return { toward_camera: toward, up };
}
