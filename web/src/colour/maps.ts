/** The colour of a place, a label and a value. */
import { coloured, grey, type Lab, mixed } from "./oklab";

/** Colours of the places of a drawing: hues as in the server's pictures, or what the colour-blind tell apart too. */
export type Palette = "hues" | "safe";

/** The colour of a place, `along` the longer side of the drawing's box and `across`, both in [0, 1]. */
export function place(palette: Palette, along: number, across: number): Lab {
  return palette === "hues" ? hues(along, across) : safe(along, across);
}

/** The hue goes along, not all the way round, so that the two ends differ; the lightness goes across. */
function hues(along: number, across: number): Lab {
  return coloured(0.54 + 0.32 * across, 0.16, 0.72 - 0.8 * along - 0.1 * across);
}

/**
 * Blue over red to yellow along, dark to light across. Those who see no red or no green tell places along by their blue
 * or yellow and places across by their lightness; nobody sees the light grey of what is uncertain.
 */
function safe(along: number, across: number): Lab {
  return coloured(0.4 + 0.22 * along + 0.24 * across, 0.15, 0.73 + 0.5 * along);
}

/** Confidence from which a colour is full, and up to which there is none. */
const SURE = 0.7;
const UNSURE = 0.3;
/** The grey of what is matched without confidence. */
const DOUBTFUL = grey(0.76);

/** The colour as far as it is believed. */
export function believed(colour: Lab, confidence: number): Lab {
  const doubt = Math.min(1, Math.max(0, (SURE - confidence) / (SURE - UNSURE)));
  return mixed(colour, DOUBTFUL, doubt);
}

/** What has no colour of its own. */
export const PLAIN = grey(0.88);

/** Blue below 0, white at 0, orange above; `share` in [−1, 1]. */
export function signed(share: number): Lab {
  if (Number.isNaN(share)) return PLAIN;
  const end = share < 0 ? coloured(0.45, 0.15, 0.72) : coloured(0.6, 0.17, 0.13);
  return mixed(grey(0.97), end, Math.min(1, Math.abs(share)));
}

/** A colour for each label; −1 is in no region. */
export function label(number: number): Lab {
  if (number < 0) return PLAIN;
  // The golden ratio keeps hues of labels apart however many there are; lightness tells near hues apart.
  return coloured(0.55 + 0.14 * (number % 3), 0.15, number * 0.618);
}
