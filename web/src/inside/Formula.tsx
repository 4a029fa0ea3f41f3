/** A formula, typeset as MathML. */
import { useEffect, useRef } from "preact/hooks";
import temml from "temml";

export function Formula({ latex, text }: { latex: string; text: string }) {
  const place = useRef<HTMLSpanElement>(null);
  useEffect(() => {
    if (place.current) temml.render(latex, place.current);
  }, [latex]);
  return (
    <span ref={place} class="formula">
      {text}
    </span>
  );
}
