/** Files that are chosen or dropped: a drawing goes onto the sheet, a mesh beside it. */
import { signal } from "@preact/signals";
import { drawingOf, isMesh } from "../drawing/files";
import { landmarks } from "./corrections";
import { edit } from "./drawing";
import { takeFile } from "./mesh";

/** Why a file was not taken before it was sent. */
export const untaken = signal<string | null>(null);

export async function take(file: File) {
  untaken.value = null;
  if (isMesh(file.name)) return takeFile(file);
  try {
    const drawing = await drawingOf(file);
    landmarks.value = [];
    edit(drawing);
  } catch (error) {
    untaken.value = error instanceof Error ? error.message : String(error);
  }
}
