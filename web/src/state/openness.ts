/** Whether what is drawn by hand is still open: lines that enclose nothing are an outline begun, not a thin figure. */
import { signal } from "@preact/signals";
import type { SketchDocument } from "../api/types";
import type { Drawing } from "../drawing/drawing";
import { boxOf } from "../geometry/flat";

/** Whether lines that enclose nothing are matched all the same: a figure of sticks. */
export const takesLines = signal(false);

/** The share of the figure's box, in width and in height, from which on a line is the whole figure. */
const WHOLE = 0.9;

/** What is missing of a drawing by hand, in words; nothing where it can be matched. */
export function missingOf(drawing: Drawing, document: SketchDocument): string | null {
  const figure = document.figures?.[0];
  if (drawing.ground !== null || !figure) return null;
  const whole = boxOf(figure.box.flat());
  const isWhole = document.warnings.some(({ code, box }) => {
    if (code !== "line_as_limb" || !box) return false;
    const { width, height } = boxOf(box.flat());
    return width > WHOLE * whole.width && height > WHOLE * whole.height;
  });
  return isWhole ? "The line encloses nothing yet: bring its ends together." : null;
}
