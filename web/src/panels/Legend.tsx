/** What the colours of the mesh say, and what can be done with a mesh that is matched. */
import { coloured } from "../state/colouring";
import { answer, finalAnswer } from "../state/live";
import { tool } from "../state/tools";
import { Icon } from "./icons";

export function Legend() {
  if (!answer.value) return null;
  return (
    <p class="legend">
      {coloured.value.by === "places" && "The same colour is the same place; grey is uncertain."}
      {tool.value !== "pose" && (
        <button
          type="button"
          disabled={!finalAnswer.value}
          onClick={() => {
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
