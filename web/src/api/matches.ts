/** Calls about matches. */
import { json, post } from "./call";
import type { Evaluation, Known, Match, MatchRequest, Result } from "./types";

export const create = (request: MatchRequest) =>
  json<Match>("/v1/matches", post(JSON.stringify(request), "application/json"));

export const cancel = (id: string) => json<Match>(`/v1/matches/${id}/cancel`, { method: "POST" });

export const result = (id: string, signal: AbortSignal) => json<Result>(`/v1/matches/${id}/result`, { signal });

/** The answer at first sight, while the match runs. */
export const preview = (id: string, signal: AbortSignal) =>
  json<Result>(`/v1/matches/${id}/result?preview=true`, { signal });

/** What the answer, or an alternative, is worth by what is known. */
export const evaluate = (id: string, alternative: number | null, known: Known, signal: AbortSignal) =>
  json<Evaluation>(
    `/v1/matches/${id}/evaluations${alternative === null ? "" : `?alternative=${alternative}`}`,
    post(JSON.stringify(known), "application/json", signal),
  );

export const picture = (id: string, alternative: number | null, width: number) =>
  `/v1/matches/${id}/picture?format=png&width=${width}${alternative === null ? "" : `&alternative=${alternative}`}`;
