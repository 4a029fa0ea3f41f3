/** A formula, typeset as MathML; it breaks between its terms, since MathML itself does not. */
import { useEffect, useRef } from "preact/hooks";
import temml from "temml";

export function Formula({ latex, text }: { latex: string; text: string }) {
  const place = useRef<HTMLSpanElement>(null);
  useEffect(() => {
    const parts = terms(latex).map((term) => {
      const part = document.createElement("span");
      temml.render(term, part);
      return part;
    });
    // Spaces between them, where a line may end.
    place.current?.replaceChildren(...parts.flatMap((part) => [part, " "]));
  }, [latex]);
  return (
    <span ref={place} class="formula">
      {text}
    </span>
  );
}

/** The terms of a formula, each but the first with its sign; what stands in brackets is one. */
function terms(latex: string): string[] {
  let depth = 0;
  let [found, begun] = [[] as string[], ""];
  for (const piece of latex.split(/( \+ |, \\; |[{}()])/)) {
    if (piece === "{" || piece === "(") depth++;
    if (piece === "}" || piece === ")") depth--;
    if (piece === " + " && depth === 0) [found, begun] = [[...found, begun], "{} + "];
    else if (piece === ", \\; ") [found, begun] = [[...found, `${begun},`], ""];
    else begun += piece;
  }
  return [...found, begun];
}
