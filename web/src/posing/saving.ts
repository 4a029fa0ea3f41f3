/** Poses as files. */
import { signal } from "@preact/signals";
import * as poses from "../api/poses";
import { words } from "../api/trouble";
import type { PoseRequest } from "../api/types";
import { isYUp } from "../drawing/drawing";
import { requested } from "../geometry/handles";
import { named } from "../panels/words";
import { frame, frames, handles } from "../state/handles";
import type { Answer } from "../state/live";
import { taken } from "./taken";

/** The format that is being made, or why it was not. */
export const saving = signal<{ format: poses.Format } | { refused: string } | null>(null);

/** Asks the server for what is shown and lets the browser save it. */
export async function save(answer: Answer, format: poses.Format) {
  saving.value = { format };
  const number = taken.value ? 0 : frame.value;
  try {
    const file = await poses.during(request(answer), new AbortController().signal, ({ id }) =>
      poses.file(id, format, number),
    );
    const name = named(answer.mesh.document.name).replace(/\.\w+$/, "");
    handOver(file, `${name} posed.${format}`);
    saving.value = null;
  } catch (error) {
    saving.value = { refused: words(error) };
  }
}

function request(answer: Answer): PoseRequest {
  if (taken.value) return taken.value.request;
  return { match: answer.match.id, ...requested(handles.value, frames.value, isYUp(answer.reading.of)) };
}

function handOver(file: Blob, name: string) {
  const address = URL.createObjectURL(file);
  Object.assign(document.createElement("a"), { href: address, download: name }).click();
  URL.revokeObjectURL(address);
}
