/** What each stage took. */
import { answer } from "../state/live";

export function Timings() {
  const timings = answer.value?.result.timings_ms;
  if (!timings) return <p class="hint">There is no answer yet.</p>;
  const longest = Math.max(...Object.values(timings));
  return (
    <table class="timings">
      <caption>Milliseconds by stage</caption>
      <tbody>
        {Object.entries(timings)
          .sort(([, a], [, b]) => b - a)
          .map(([stage, ms]) => (
            <tr key={stage}>
              <th scope="row">{stage}</th>
              <td>{ms.toFixed(1)}</td>
              <td>
                <meter min={0} max={longest} value={ms} aria-label={stage} />
              </td>
            </tr>
          ))}
      </tbody>
    </table>
  );
}
