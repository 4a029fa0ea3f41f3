/** What the colours of the mesh say, and what can be done with a mesh that is matched. */
import { coloured } from "../state/colouring";
import { handles, setSome } from "../state/handles";
import { answer, finalAnswer } from "../state/live";
import { tool } from "../state/tools";
import { Icon } from "./icons";

const MEANINGS = {
  places: "The same colour is the same place; grey is uncertain.",
  regions: "The same colour is the same region; grey is in none.",
  values: "Blue is below zero, orange above.",
};

export function Legend() {
  if (!answer.value) return null;
  return (
    <p class="legend">
      {MEANINGS[coloured.value.by]}
      {tool.value !== "pose" && (
        <button
          type="button"
          disabled={!finalAnswer.value}
          onClick={() => {
            if (handles.value.length === 0 && finalAnswer.value) setSome(finalAnswer.value.reading.flat);
            tool.value = "pose";
          }}
        >
          <Icon name="pose" />
          Pose it
        </button>
      )}
    </p>
  );
}
