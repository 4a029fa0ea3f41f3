/** The objective from iteration to iteration. */
import { answer } from "../state/live";

const [WIDTH, HEIGHT] = [640, 260];
const MARGIN = { left: 70, right: 12, top: 12, bottom: 34 };

export function Objective() {
  const solver = answer.value?.result.solver;
  if (!solver) return <p class="hint">There is no answer yet.</p>;
  const { history, iterations, objective, stopped, regulariser } = solver;
  return (
    <>
      <p>
        {regulariser}: objective {objective.toPrecision(7)} after {iterations} iterations,{" "}
        {stopped === "converged" ? "converged" : "the most that were allowed"}.
      </p>
      {history.length > 1 ? (
        <Curve history={history} />
      ) : (
        <p class="hint">It is solved in one step: there is no curve.</p>
      )}
    </>
  );
}

function Curve({ history }: { history: number[] }) {
  const [low, high] = [Math.min(...history), Math.max(...history)];
  const across = WIDTH - MARGIN.left - MARGIN.right;
  const down = HEIGHT - MARGIN.top - MARGIN.bottom;
  const x = (i: number) => MARGIN.left + (across * i) / (history.length - 1);
  const y = (value: number) => MARGIN.top + (down * (high - value)) / (high - low || 1);
  const line = history.map((value, i) => `${x(i).toFixed(1)} ${y(value).toFixed(1)}`).join("L");
  return (
    <svg class="curve" viewBox={`0 0 ${WIDTH} ${HEIGHT}`} role="img" aria-label={`From ${high} down to ${low}`}>
      <path class="axes" d={`M${MARGIN.left} ${MARGIN.top}v${down}h${across}`} />
      <path class="line" d={`M${line}`} />
      {[high, low].map((value) => (
        <text key={value} x={MARGIN.left - 8} y={y(value) + 5} text-anchor="end">
          {value.toPrecision(5)}
        </text>
      ))}
      {[0, history.length - 1].map((i) => (
        <text key={i} x={x(i)} y={HEIGHT - 12} text-anchor={i === 0 ? "start" : "end"}>
          {i === 0 ? "start" : `iteration ${i}`}
        </text>
      ))}
    </svg>
  );
}
