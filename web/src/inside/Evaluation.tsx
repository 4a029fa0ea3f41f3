/** What the answer is worth, where a file says what is true. */
import { useSignal, useSignalEffect } from "@preact/signals";
import { evaluate } from "../api/matches";
import { words } from "../api/trouble";
import type { Evaluation as Judged, Known } from "../api/types";
import { FileButton } from "../panels/Button";
import { chosen, finalAnswer } from "../state/live";
import { Curve } from "./Curve";

export function Evaluation() {
  const known = useSignal<{ name: string; truth: Known } | null>(null);
  const judged = useSignal<Judged | null>(null);
  const trouble = useSignal("");
  useSignalEffect(() => {
    const [now, alternative] = [finalAnswer.value, chosen.value];
    judged.value = null;
    if (!now || !known.value) return;
    const stop = new AbortController();
    evaluate(now.match.id, alternative, known.value.truth, stop.signal).then(
      (found) => {
        judged.value = found;
      },
      (error) => {
        if (!stop.signal.aborted) trouble.value = words(error);
      },
    );
    return () => stop.abort();
  });
  const read = async (file: File) => {
    trouble.value = "";
    known.value = null;
    try {
      known.value = { name: file.name, truth: truthOf(JSON.parse(await file.text())) };
    } catch {
      trouble.value = `${file.name} is no JSON.`;
    }
  };
  return (
    <>
      <p class="hint">
        Points of the drawing and their vertices of the mesh,{" "}
        <code>
          {"{"}"pairs": …{"}"}
        </code>
        , or regions of both,{" "}
        <code>
          {"{"}"labels": …{"}"}
        </code>
        , as <a href="/docs">the API</a> takes them. What is shown is judged, an alternative too.
      </p>
      <div class="group">
        <FileButton icon="file" label="Open what is true, as JSON" accept=".json,application/json" onFile={read}>
          {known.value?.name ?? "Open what is true"}
        </FileButton>
      </div>
      {trouble.value && (
        <p class="trouble" role="alert">
          {trouble.value}
        </p>
      )}
      {judged.value &&
        ("pairs" in judged.value ? <Pairs of={judged.value.pairs} /> : <Labels of={judged.value.labels} />)}
    </>
  );
}

/** What a file says; the truths of test cases say of pairs no more than the pairs themselves. */
const truthOf = (said: Record<string, unknown>) => ("points" in said ? { pairs: said } : said) as Known;

const rounded = (value: number | null | undefined) => value?.toFixed(4) ?? "–";

function Pairs({ of }: { of: Extract<Judged, { pairs: unknown }>["pairs"] }) {
  const { coherent, pointwise, thresholds, best, unit } = of;
  const rows = [
    { name: `as ${best}`, measures: coherent },
    { name: "each point by itself", measures: pointwise },
  ];
  return (
    <>
      <table>
        <caption>Geodesic errors; 1 is {unit.toPrecision(4)} in the mesh's file</caption>
        <thead>
          <tr>
            <th scope="col">read</th>
            <th scope="col">mean</th>
            <th scope="col">median</th>
            <th scope="col">area under the curve</th>
            {coherent.within.map(({ limit }) => (
              <th key={limit} scope="col">
                up to {limit}
              </th>
            ))}
          </tr>
        </thead>
        <tbody>
          {rows.map(({ name, measures }) => (
            <tr key={name}>
              <th scope="row">{name}</th>
              <td>{rounded(measures.mean)}</td>
              <td>{rounded(measures.median)}</td>
              <td>{rounded(measures.auc)}</td>
              {measures.within.map(({ limit, share }) => (
                <td key={limit}>{(100 * share).toFixed(1)} %</td>
              ))}
            </tr>
          ))}
        </tbody>
      </table>
      <Curve
        values={coherent.curve}
        range={[0, 1]}
        ends={[`error ${thresholds[0]}`, `error ${thresholds.at(-1)}`]}
        label={`The share of points up to an error, from ${thresholds[0]} to ${thresholds.at(-1)}`}
      />
    </>
  );
}

function Labels({ of: { points, right, share, regions } }: { of: Extract<Judged, { labels: unknown }>["labels"] }) {
  return (
    <>
      <p>
        {right} of {points} points are in the right region
        {share !== null && share !== undefined && `, ${(100 * share).toFixed(1)} %`}.
      </p>
      <table>
        <caption>By region</caption>
        <thead>
          <tr>
            <th scope="col">label</th>
            <th scope="col">points</th>
            <th scope="col">right</th>
          </tr>
        </thead>
        <tbody>
          {regions.map(({ label, points, right }) => (
            <tr key={label}>
              <th scope="row">{label}</th>
              <td>{points}</td>
              <td>{right}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </>
  );
}
