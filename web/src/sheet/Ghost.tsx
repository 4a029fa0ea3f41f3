/** Until a drawing by hand has been matched: a faint drawing of the mesh, to be traced or taken. */
import { useComputed } from "@preact/signals";
import { strokesOf } from "../drawing/files";
import { linePath } from "../drawing/ink";
import { drawing } from "../state/drawing";
import { answer } from "../state/live";
import { mesh } from "../state/mesh";

export function Ghost() {
  const lines = useComputed(() => {
    const outline = mesh.value?.outline;
    return outline ? strokesOf(outline).map(({ points }) => points.map(([x, y]): [number, number] => [x, y])) : [];
  });
  if (drawing.value.ground !== null || answer.value) return null;
  return <path class="ghost" d={lines.value.map(linePath).join("")} />;
}
