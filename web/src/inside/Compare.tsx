/** The presets side by side: what each makes of this drawing, and the settings in which they differ. */
import { useSignal } from "@preact/signals";
import { failure, follow } from "../api/jobs";
import * as matches from "../api/matches";
import { words } from "../api/trouble";
import type { Match, Result } from "../api/types";
import { Picture } from "../panels/Picture";
import { RATINGS } from "../panels/words";
import { type Answer, finalAnswer } from "../state/live";
import { madeMatch } from "../state/tidy";

const NAMES = ["automatic", "thesis"] as const;

/** The width of a picture, in pixels. */
const WIDTH = 640;

interface Made {
  match: Match;
  result: Result;
}

type State = { of: Answer } & ({ made: [Made, Made] } | { words: string } | { isRunning: true });

export function Compare() {
  const state = useSignal<State | null>(null);
  const now = finalAnswer.value;
  if (!now) return <p class="hint">There is no answer yet.</p>;
  const shown = state.value?.of === now ? state.value : null;
  const compare = async () => {
    state.value = { of: now, isRunning: true };
    try {
      const [automatic, thesis] = await Promise.all(NAMES.map((preset) => made(now, preset)));
      state.value = { of: now, made: [automatic as Made, thesis as Made] };
    } catch (error) {
      state.value = { of: now, words: words(error) };
    }
  };
  return (
    <>
      <p class="hint">Both presets match this drawing, with nothing else said.</p>
      <div class="group">
        <button type="button" disabled={shown !== null && "isRunning" in shown} onClick={compare}>
          Match by both
        </button>
        {shown && "isRunning" in shown && <progress aria-label="Matching by both presets" />}
      </div>
      {shown && "words" in shown && (
        <p class="trouble" role="alert">
          {shown.words}
        </p>
      )}
      {shown && "made" in shown && <SideBySide made={shown.made} />}
    </>
  );
}

async function made({ mesh, reading }: Answer, preset: (typeof NAMES)[number]): Promise<Made> {
  const { signal } = new AbortController();
  const started = await matches.create({ preset, mesh: mesh.document.id, sketch: reading.document.id });
  madeMatch(started.id);
  const match = await follow(started, () => {}, signal);
  if (match.status !== "succeeded") throw failure(match);
  return { match, result: await matches.result(match.id, signal) };
}

function SideBySide({ made }: { made: [Made, Made] }) {
  return (
    <>
      <div class="side-by-side">
        {made.map(({ match, result }, i) => (
          <figure key={match.id}>
            <Picture src={matches.picture(match.id, null, WIDTH)} alt={`The drawing and the mesh by ${NAMES[i]}`} />
            <figcaption>
              <strong>{NAMES[i]}</strong>: {result.rating ? RATINGS[result.rating].title : "not rated"}, confidence{" "}
              {result.confidence.toFixed(2)}
            </figcaption>
          </figure>
        ))}
      </div>
      <Differences requests={[made[0].result.request, made[1].result.request]} />
    </>
  );
}

function Differences({ requests }: { requests: [object, object] }) {
  const [ones, others] = requests.map((request) => flattened(request, "")) as [
    Map<string, string>,
    Map<string, string>,
  ];
  const names = [...new Set([...ones.keys(), ...others.keys()])].filter((name) => ones.get(name) !== others.get(name));
  return (
    <div class="scrolled">
      <table class="differences">
        <caption>Settings in which they differ</caption>
        <thead>
          <tr>
            <th scope="col">setting</th>
            {NAMES.map((name) => (
              <th key={name} scope="col">
                {name}
              </th>
            ))}
          </tr>
        </thead>
        <tbody>
          {names.sort().map((name) => (
            <tr key={name}>
              <th scope="row">{name}</th>
              <td>{ones.get(name) ?? "–"}</td>
              <td>{others.get(name) ?? "–"}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}

/** The settings of a request by their names, those within others with both. */
function flattened(request: object, within: string): Map<string, string> {
  const entries = Object.entries(request).flatMap(([name, value]): [string, string][] => {
    const whole = `${within}${name.replaceAll("_", " ")}`;
    if (value === null || value === undefined) return [];
    if (typeof value === "object" && !Array.isArray(value)) return [...flattened(value, `${whole}, `)];
    return [[whole, Array.isArray(value) ? JSON.stringify(value) : String(value)]];
  });
  return new Map(entries);
}
