/** Calls about matches. */
import { json, post } from "./call";
import { key } from "./key";
import { Refusal } from "./trouble";
import type { Match, MatchRequest, Result, SignedLinks } from "./types";

/** How often a match is asked after where its events do not come, in ms. */
const POLL = 1000;

export const create = (request: MatchRequest) =>
  json<Match>("/v1/matches", post(JSON.stringify(request), "application/json"));

export const cancel = (id: string) => json<Match>(`/v1/matches/${id}/cancel`, { method: "POST" });

export const result = (id: string, signal: AbortSignal) => json<Result>(`/v1/matches/${id}/result`, { signal });

/** The answer at first sight, while the match runs. */
export const preview = (id: string, signal: AbortSignal) =>
  json<Result>(`/v1/matches/${id}/result?preview=true`, { signal });

export const picture = (id: string, alternative: number | null, width: number) =>
  `/v1/matches/${id}/picture?format=png&width=${width}${alternative === null ? "" : `&alternative=${alternative}`}`;

const isOver = (match: Match) => match.status !== "queued" && match.status !== "running";

/** Follows a match by its events to its end, and by asking where they break off; `seen` is told of every change. */
export async function follow(started: Match, seen: (match: Match) => void, signal: AbortSignal): Promise<Match> {
  let match = await byEvents(started, seen, signal);
  while (!isOver(match)) {
    await new Promise((resolve) => setTimeout(resolve, POLL));
    match = await json<Match>(started.links.self, { signal });
    seen(match);
  }
  return match;
}

/** The match when it is over or its events break off. */
async function byEvents(match: Match, seen: (match: Match) => void, signal: AbortSignal): Promise<Match> {
  if (isOver(match)) return match;
  const address = await eventsOf(match, signal);
  return new Promise((resolve, reject) => {
    let latest = match;
    const events = new EventSource(address);
    const end = (settle: () => void) => {
      events.close();
      settle();
    };
    events.addEventListener("status", (event) => {
      latest = JSON.parse(event.data) as Match;
      seen(latest);
      if (isOver(latest)) end(() => resolve(latest));
    });
    events.addEventListener("error", () => end(() => resolve(latest)));
    signal.addEventListener("abort", () => end(() => reject(signal.reason)), { once: true });
  });
}

/** Where the events of a match are told: signed where there is a key, for an `EventSource` cannot send one. */
async function eventsOf(match: Match, signal: AbortSignal): Promise<string> {
  if (!key.value) return match.links.events;
  const signed = await json<SignedLinks>(`${match.links.self}/links`, { signal });
  return signed.links.events ?? match.links.events;
}

/** Why a match has no result, as a refusal. */
export function failure(match: Match): Refusal {
  if (match.status === "cancelled")
    return new Refusal(409, "the match was cancelled: change the drawing to try again", [], null);
  const problem = match.error;
  return new Refusal(problem?.status ?? 500, problem?.detail ?? "the match failed", problem?.errors ?? [], null);
}
