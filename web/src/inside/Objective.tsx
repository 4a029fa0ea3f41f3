/** The objective from iteration to iteration. */
import { answer } from "../state/live";
import { Curve } from "./Curve";

export function Objective() {
  const solver = answer.value?.result.solver;
  if (!solver) return <p class="hint">There is no answer yet.</p>;
  const { history, iterations, objective, stopped, regulariser } = solver;
  const [low, high] = [Math.min(...history), Math.max(...history)];
  return (
    <>
      <p>
        {regulariser}: objective {objective.toPrecision(7)} after {iterations} iterations,{" "}
        {stopped === "converged" ? "converged" : "the most that were allowed"}.
      </p>
      {history.length > 1 ? (
        <Curve
          values={history}
          range={[low, high]}
          ends={["start", `iteration ${history.length - 1}`]}
          label={`From ${high} down to ${low}`}
        />
      ) : (
        <p class="hint">It is solved in one step: there is no curve.</p>
      )}
    </>
  );
}
