/** The answer and its alternatives, each with its picture: one click flips to it. */
import { picture } from "../api/matches";
import type { Alternative } from "../api/types";
import { answer, chosen } from "../state/live";
import { rested } from "../state/rested";
import { Picture } from "./Picture";

/** The width of a picture, in pixels: of the sketch and two views of the mesh. */
const WIDTH = 480;

const KINDS: Record<Alternative["kind"], string> = {
  mirrored: "Mirrored: seen from the other side",
  view: "Seen from elsewhere",
};

export function Alternatives() {
  const now = rested.value;
  if (!now || now.result.alternatives.length === 0) return null;
  const offered = [
    { number: null, name: "Best answer" },
    ...now.result.alternatives.map(({ kind }, number) => ({ number, name: KINDS[kind] })),
  ];
  return (
    <section class="panel" aria-labelledby="alternatives">
      <h2 id="alternatives">Not right? Take another</h2>
      <ul class="alternatives">
        {offered.map(({ number, name }) => (
          <li key={number}>
            <button
              type="button"
              aria-pressed={chosen.value === number}
              disabled={now !== answer.value}
              onClick={() => {
                chosen.value = number;
              }}
            >
              <Picture src={picture(now.match.id, number, WIDTH)} alt="" />
              <span>{name}</span>
            </button>
          </li>
        ))}
      </ul>
    </section>
  );
}
