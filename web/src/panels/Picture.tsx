/** A picture of the server's: with a key it is fetched, for an `<img>` cannot send one. */
import { useSignal, useSignalEffect } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { call } from "../api/call";
import { key } from "../api/key";

interface Props {
  src: string;
  alt: string;
  width?: number;
  height?: number;
}

export function Picture({ src, alt, ...size }: Props) {
  const address = useSignal(src);
  const fetched = useSignal<string | null>(null);
  address.value = src;
  useSignalEffect(() => {
    if (!key.value) return;
    const running = new AbortController();
    call(address.value, { headers: { accept: "image/*" }, signal: running.signal })
      .then((answer) => answer.blob())
      .then((blob) => {
        fetched.value = URL.createObjectURL(blob);
      })
      // Without its picture a choice still has its words.
      .catch(() => {});
    return () => running.abort();
  });
  const shown = fetched.value;
  useEffect(() => () => (shown ? URL.revokeObjectURL(shown) : undefined), [shown]);
  if (key.value) return <img src={shown ?? undefined} alt={alt} {...size} />;
  return <img src={src} alt={alt} loading="lazy" {...size} />;
}
