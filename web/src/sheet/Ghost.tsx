/** On the empty sheet: a faint drawing of the mesh, to be traced or taken. */
import { useComputed } from "@preact/signals";
import { strokesOf } from "../drawing/files";
import { linePath } from "../drawing/ink";
import { nothingDrawn } from "../state/drawing";
import { mesh } from "../state/mesh";
import { underway } from "./pencil";

export function Ghost() {
  const lines = useComputed(() => {
    const outline = mesh.value?.outline;
    return outline ? strokesOf(outline).map(({ points }) => points.map(([x, y]): [number, number] => [x, y])) : [];
  });
  if (!nothingDrawn.value || underway.value) return null;
  return <path class="ghost" d={lines.value.map(linePath).join("")} />;
}
