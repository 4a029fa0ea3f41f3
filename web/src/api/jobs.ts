/** Matches and poses while they run. */
import { json } from "./call";
import { Refusal } from "./trouble";
import type { Match, Pose } from "./types";

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
function byEvents<T extends Job>(job: T, seen: (job: T) => void, signal: AbortSignal): Promise<T> {
  if (isOver(job)) return Promise.resolve(job);
  return new Promise((resolve, reject) => {
    let latest = job;
    const events = new EventSource(job.links.events);
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

/** Why a job has no result, as a refusal. */
export function failure(job: Job): Refusal {
  if (job.status === "cancelled")
    return new Refusal(409, "it was cancelled: change the drawing to try again", [], null);
  const problem = job.error;
  return new Refusal(problem?.status ?? 500, problem?.detail ?? "it failed", problem?.errors ?? [], null);
}
