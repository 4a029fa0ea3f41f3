/** What can go wrong with a call, in words for whoever made it. */
import { key } from "./key";
import type { Problem, ProblemFault } from "./types";

/** The server answered no: a problem (RFC 9457), or something before it that says none. */
export class Refusal extends Error {
  constructor(
    readonly status: number,
    detail: string,
    readonly faults: ProblemFault[],
    /** Seconds after which the server asks to come again. */
    readonly retryAfter: number | null,
  ) {
    super(detail);
  }

  /** Whether the same call may succeed later. */
  get passes(): boolean {
    return this.status === 429 || this.status === 503 || this.status === 507;
  }

  static async of(answer: Response): Promise<Refusal> {
    const said = await answer.json().catch(() => null);
    const problem: Partial<Problem> = said ?? {};
    const seconds = Number.parseInt(answer.headers.get("retry-after") ?? "", 10);
    const detail = problem.detail ?? `${answer.status} ${answer.statusText}`.trim();
    return new Refusal(answer.status, detail, problem.errors ?? [], Number.isNaN(seconds) ? null : seconds);
  }
}

/** Nobody answered. */
export class Away extends Error {
  constructor() {
    super("the server does not answer");
  }
}

/** What was refused and what to do about it, as sentences; `isRetried` where the page itself asks again. */
export function words(error: unknown, isRetried = false): string {
  if (error instanceof Away) return "The server does not answer.";
  if (error instanceof Refusal && error.status === 401)
    return key.value
      ? "This key is unknown here, was revoked or has expired: enter another at the top."
      : "This server asks for a key: enter it at the top.";
  if (!(error instanceof Refusal)) return `Something went wrong in this page: ${String(error)}`;
  const [first, second] = error.faults;
  return `${first && !second ? told(first) : sentence(error.message)}${error.passes && isRetried ? "" : advice(error.status)}`;
}

/** A fault as a sentence, with its place where that is one in a file. */
export function told({ detail, place }: ProblemFault): string {
  return sentence(place && /^(line|face)/.test(place) ? `${place}: ${detail}` : detail);
}

function advice(status: number): string {
  switch (status) {
    case 403:
      return " Ask whoever gave you the key for one that may.";
    case 413:
      return " Choose a smaller file, or ask whoever runs the server to raise its limit.";
    case 415:
      return " Choose a file of one of the formats named beside the button.";
    case 429:
    case 503:
    case 507:
      return " Try it again in a while.";
    case 500:
      return " This is a fault of the server: tell whoever runs it.";
    default:
      return "";
  }
}

/** What the server says, lower case and without a full stop, as a sentence. */
export function sentence(detail: string): string {
  const stopped = /[.!?]$/.test(detail) ? detail : `${detail}.`;
  return stopped.charAt(0).toUpperCase() + stopped.slice(1);
}
