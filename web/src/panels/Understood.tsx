/** The server's picture of what it read, on the sheet's card. */
import { useRef } from "preact/hooks";
import { sketchPicture } from "../api/shapes";
import { drawing } from "../state/drawing";
import { reading, stage } from "../state/live";
import { IconButton } from "./Button";
import { Picture } from "./Picture";
import { readingWarnings } from "./words";

/** The width of the picture, in pixels. */
const WIDTH = 900;

export function Understood() {
  const dialog = useRef<HTMLDialogElement>(null);
  const read = reading.value?.of === drawing.value ? reading.value : null;
  if (!read || stage.value.kind === "open") return null;
  const warnings = readingWarnings(read);
  return (
    <>
      <button type="button" class="quiet" aria-haspopup="dialog" onClick={() => dialog.current?.showModal()}>
        See what was understood{warnings.length > 0 && ` (${warnings.length})`}
      </button>
      <dialog ref={dialog} class="understood" aria-label="What was understood of the drawing">
        <header>
          <h2>What was understood</h2>
          <IconButton icon="close" label="Close" onClick={() => dialog.current?.close()} />
        </header>
        <Picture
          src={sketchPicture(read.document.id, WIDTH)}
          alt={`The figure over the drawing: ${read.document.vertices} points`}
        />
        <ul>
          {warnings.map((warning) => (
            <li key={warning}>{warning}</li>
          ))}
        </ul>
      </dialog>
    </>
  );
}
