/** One call to the server that the page came from. */
import { isWanted, withKey } from "./key";
import { Away, Refusal } from "./trouble";

/**
 * The answer to a call.
 *
 * @throws {Refusal} where the server says no, {@link Away} where nobody answers, an AbortError where `signal` fires.
 */
export async function call(path: string, options: RequestInit = {}): Promise<Response> {
  let answer: Response;
  try {
    answer = await fetch(path, { ...options, headers: withKey(options.headers) });
  } catch (error) {
    if (options.signal?.aborted) throw error;
    throw new Away();
  }
  // What stands before a server says so where the server is away.
  if (answer.status === 502 || answer.status === 504) throw new Away();
  if (answer.status === 401) isWanted.value = true;
  if (!answer.ok) throw await Refusal.of(answer);
  return answer;
}

/** The JSON that a call answers. */
export async function json<T>(path: string, options?: RequestInit): Promise<T> {
  const answer = await call(path, options);
  return (await answer.json()) as T;
}

/** Options of a POST with a body of this type. */
export function post(body: BodyInit, type: string, signal?: AbortSignal): RequestInit {
  return { method: "POST", headers: { "content-type": type }, body, ...(signal && { signal }) };
}
