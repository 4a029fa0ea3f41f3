/** The answer in words. */

import { sentence } from "../api/trouble";
import type { Result } from "../api/types";
import type { Reading } from "../state/live";

/** What a rating means; docs/method.md has the errors measured for each. */
export const RATINGS = {
  high: { title: "Good match", meaning: "Nearly every place should be right." },
  medium: { title: "Fair match", meaning: "Most places should be right; legs may be swapped." },
  low: { title: "Uncertain match", meaning: "Take it as a guess: try an alternative or set some landmarks." },
} as const;

/** Below this confidence a place is more grey than coloured. */
const FADED = 0.5;

/** Why the rating is what it is. */
export function reasons({ correspondences, alignment }: Result): string[] {
  const faded = correspondences.filter(({ confidence }) => confidence < FADED).length / correspondences.length;
  const parts = [
    alignment && `The outline fits this view ${fit(alignment.contour_cost)}.`,
    faded > 0 && `${percent(faded)} of the drawing is uncertain and grey.`,
    !alignment && "Without an alignment the confidence says only how well the map agrees with its way back.",
  ];
  return parts.filter((part) => typeof part === "string");
}

/** The contour cost goes from 0, alike, to 0.4. */
function fit(cost: number): string {
  if (cost < 0.04) return "closely";
  return cost < 0.08 ? "roughly" : "badly";
}

const percent = (share: number) => `${Math.max(1, Math.round(100 * share))} %`;

/** What was read of the drawing and what to know of it, as sentences. */
export const readingWarnings = ({ document }: Reading) => [
  ...new Set(document.warnings.map(({ detail }) => sentence(detail))),
];

export const STAGES: Record<string, string> = {
  "": "Matching",
  spectrum: "Preparing the mesh",
  alignment: "Looking for the view",
  preview: "Looking closer",
  regions: "Finding regions",
  descriptors: "Comparing both shapes",
  map: "Solving for the map",
  points: "Reading the points",
  finished: "Fetching the answer",
};

const NAMES: Record<string, string> = { quadruped: "Cat", biped: "Person" };

/** What an example or an uploaded mesh is called. */
export function named(name: string | null | undefined): string {
  const bare = (name ?? "Mesh").replace(/\.obj$/, "");
  return NAMES[bare] ?? name ?? "Mesh";
}
