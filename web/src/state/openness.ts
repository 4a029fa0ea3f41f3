/** Whether what is drawn by hand is still open: lines that enclose little are an outline begun, not a thin figure. */
import { signal } from "@preact/signals";
import type { SketchDocument } from "../api/types";
import { type Drawing, unit } from "../drawing/drawing";
import { WIDTH } from "../drawing/ink";
import { lengthOf, looseEnds } from "../drawing/stroke";

/** Whether lines that enclose little are matched all the same: a figure of sticks. */
export const takesLines = signal(false);

/** The area of a figure, in areas of its ink, from which on its lines enclose it: half a cat has 2, a cat 4. */
const ENCLOSED = 3;

/** What is missing of a drawing by hand, in words; nothing where it can be matched. */
export function missingOf({ ground, strokes, frame }: Drawing, document: SketchDocument): string | null {
  if (ground !== null || !document.warnings.some(({ code }) => code === "line_as_limb")) return null;
  const one = unit(frame);
  const ink = lengthOf(strokes) * WIDTH * one;
  const isOpen = document.area < ENCLOSED * ink && looseEnds(strokes, one).length > 1;
  return isOpen ? "The outline is still open: bring its ends together." : null;
}
