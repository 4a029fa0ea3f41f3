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

/** What deletes all that was brought before this match, whatever is brought until it is called. */
export function sweeper(now: Match): () => Promise<void> {
  const [oldMatches, oldSketches] = [before(matches, now.id), before(sketches, now.sketch)];
  return async () => {
    await removed("matches", matches, oldMatches);
    await removed("sketches", sketches, oldSketches);
  };
}

const before = (made: Set<string>, now: string) => [...made].filter((id) => id !== now && !given.has(id));

async function removed(kind: "matches" | "sketches", made: Set<string>, old: string[]) {
  for (const id of old) {
    // What cannot be deleted now, since a match needs it, is deleted after the next.
    const isGone = await call(`/v1/${kind}/${id}`, { method: "DELETE" }).then(
      () => true,
      () => false,
    );
    if (isGone) made.delete(id);
  }
}
