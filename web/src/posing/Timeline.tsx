/** The frames, each a pose of all handles, and their play. */
import { IconButton } from "../panels/Button";
import { addFrame, frame, frames, isPlacing, removeFrame, rest } from "../state/handles";
import { isPlaying, pause, play } from "./playing";

export function Timeline() {
  const count = frames.value.length;
  const still = (does: () => void) => () => {
    pause();
    isPlacing.value = false;
    does();
  };
  return (
    <div class="row timeline" role="group" aria-label="Frames">
      <IconButton
        icon={isPlaying.value ? "pause" : "play"}
        label={isPlaying.value ? "Pause" : "Play the frames"}
        disabled={count < 2}
        onClick={isPlaying.value ? pause : still(play)}
      />
      <ol>
        {frames.value.map((_, i) => (
          <li key={i}>
            <button
              type="button"
              aria-label={`Frame ${i + 1}`}
              aria-pressed={frame.value === i && !isPlaying.value}
              onClick={still(() => {
                frame.value = i;
              })}
            >
              {i + 1}
            </button>
          </li>
        ))}
      </ol>
      <IconButton icon="plus" label="Add a frame after this one" onClick={still(addFrame)} />
      <IconButton icon="clear" label="Remove this frame" disabled={count < 2} onClick={still(removeFrame)} />
      <button type="button" class="quiet" onClick={still(rest)}>
        This frame at rest
      </button>
    </div>
  );
}
