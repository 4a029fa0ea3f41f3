/** Matches and poses while they run. */
import { json } from "./call";
import { key } from "./key";
import { Refusal } from "./trouble";
import type { Match, Pose, SignedLinks } from "./types";

type Job = Match | Pose;

/** How often a job is asked after where its events do not come, in ms. */
const POLL = 1000;

const isOver = ({ status }: Job) => status !== "queued" && status !== "running";

/** Follows a job by its events to its end, and by asking where they break off; `seen` is told of every change. */
export async function follow<T extends Job>(started: T, seen: (job: T) => void, signal: AbortSignal): Promise<T> {
  let job = await byEvents(started, seen, signal);
  while (!isOver(job)) {
    await new Promise((resolve) => setTimeout(resolve, POLL));
    job = await json<T>(started.links.self, { signal });
    seen(job);
  }
  return job;
}

/** The job when it is over or its events break off. */
async function byEvents<T extends Job>(job: T, seen: (job: T) => void, signal: AbortSignal): Promise<T> {
  if (isOver(job)) return job;
  const address = await eventsOf(job, signal);
  return new Promise((resolve, reject) => {
    let latest = job;
    const events = new EventSource(address);
    const end = (settle: () => void) => {
      events.close();
      settle();
    };
    events.addEventListener("status", (event) => {
      latest = JSON.parse(event.data) as T;
      seen(latest);
      if (isOver(latest)) end(() => resolve(latest));
    });
    events.addEventListener("error", () => end(() => resolve(latest)));
    signal.addEventListener("abort", () => end(() => reject(signal.reason)), { once: true });
  });
}

/** Where the events of a job are told: signed where there is a key, for an `EventSource` cannot send one. */
async function eventsOf(job: Job, signal: AbortSignal): Promise<string> {
  if (!key.value) return job.links.events;
  const signed = await json<SignedLinks>(`${job.links.self}/links`, { signal });
  return signed.links.events ?? job.links.events;
}

/** Why a job has no result, as a refusal. */
export function failure(job: Job): Refusal {
  if (job.status === "cancelled")
    return new Refusal(409, "it was cancelled: change the drawing to try again", [], null);
  const problem = job.error;
  return new Refusal(problem?.status ?? 500, problem?.detail ?? "it failed", problem?.errors ?? [], null);
}
