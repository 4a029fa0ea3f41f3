/**
 * What the page leaves on the server. One match and one sketch for every stroke would stay there for ever: those that a
 * newer one has replaced are deleted, unless somebody was given their ids.
 */
import { call } from "../api/call";
import type { Match } from "../api/types";

/** Matches and sketches that this page brought to the server. */
const matches = new Set<string>();
const sketches = new Set<string>();
/** Ids that a link or a copied request names. */
const given = new Set<string>();

export const madeMatch = (id: string) => void matches.add(id);
export const madeSketch = (id: string) => void sketches.add(id);

export function give(...ids: string[]) {
  for (const id of ids) given.add(id);
}

/** Deletes what came before this match. */
export async function sweep(now: Match) {
  await removed("matches", matches, now.id);
  await removed("sketches", sketches, now.sketch);
}

async function removed(kind: "matches" | "sketches", made: Set<string>, now: string) {
  for (const id of [...made].filter((id) => id !== now && !given.has(id))) {
    // What cannot be deleted now, since a match needs it, is deleted after the next.
    const isGone = await call(`/v1/${kind}/${id}`, { method: "DELETE" }).then(
      () => true,
      () => false,
    );
    if (isGone) made.delete(id);
  }
}
