/** The key that the server asks for, where it asks for one: kept in this browser until its window is closed. */
import { signal } from "@preact/signals";

const NAME = "key";

export const key = signal(sessionStorage.getItem(NAME) ?? "");

/** Whether the server has asked for a key, or for another. */
export const isWanted = signal(false);

/** Begins anew with this key. */
export function begin(text: string) {
  sessionStorage.setItem(NAME, text);
  location.reload();
}

/** The headers of a call with the key. */
export function withKey(headers: HeadersInit | undefined): Headers {
  const all = new Headers(headers);
  if (key.value) all.set("authorization", `Bearer ${key.value}`);
  return all;
}
