/** The landmarks as a list, and how to set one. */
import { landmarks, remove } from "../state/corrections";
import { faulty } from "../state/faulty";
import { answer } from "../state/live";
import { tool } from "../state/tools";
import { IconButton } from "./Button";

export function Landmarks() {
  if (landmarks.value.length === 0 && tool.value !== "landmark" && !answer.value) return null;
  return (
    <section class="panel" aria-labelledby="landmarks">
      <h2 id="landmarks">Landmarks</h2>
      <p class="hint" role="status">
        {hint()}
      </p>
      {tool.value !== "landmark" && (
        <button
          type="button"
          onClick={() => {
            tool.value = "landmark";
          }}
        >
          Set a landmark
        </button>
      )}
      <ul class="landmarks">
        {landmarks.value.map(({ id, at, vertex }) => (
          <li key={id} class={faulty.value.has(id) ? "faulty" : ""}>
            <span class="number">{id}</span>
            {at && vertex !== null ? `vertex ${vertex}` : at ? "waits for the mesh" : "waits for the drawing"}
            <IconButton icon="close" label={`Remove landmark ${id}`} onClick={() => remove(id)} />
          </li>
        ))}
      </ul>
    </section>
  );
}

function hint(): string {
  const lacking = landmarks.value.find(({ at, vertex }) => at === null || vertex === null);
  if (lacking) return `Now click the same place on the ${lacking.at ? "mesh" : "drawing"}.`;
  if (tool.value !== "landmark") return "Two places that you know to be the same pull the whole match right.";
  return "Click a place on the drawing, then the same place on the mesh. Drag a landmark to move it.";
}
