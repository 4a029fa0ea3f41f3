/** What to do on the empty sheet. */
import { withStrokes } from "../drawing/drawing";
import { strokesOf } from "../drawing/files";
import { drawing, edit, nothingDrawn } from "../state/drawing";
import { mesh } from "../state/mesh";

export function Start() {
  if (!nothingDrawn.value) return null;
  const outline = mesh.value?.outline;
  return (
    <p class="start">
      Draw{outline && " or trace"} the outline: it is matched as you lift the pen.
      {outline && (
        <button type="button" onClick={() => edit(withStrokes(drawing.value, strokesOf(outline)))}>
          Draw it for me
        </button>
      )}
    </p>
  );
}
