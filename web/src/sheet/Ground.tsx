/** The file below the strokes. */
import { useComputed } from "@preact/signals";
import { useEffect, useState } from "preact/hooks";
import { linePath } from "../drawing/ink";
import { drawing } from "../state/drawing";

export function Ground() {
  const ground = useComputed(() => drawing.value.ground).value;
  const frame = useComputed(() => drawing.value.frame).value;
  const file = ground?.kind === "picture" || ground?.kind === "svg" ? ground.file : null;
  const [address, setAddress] = useState<string | null>(null);
  useEffect(() => {
    if (!file) return setAddress(null);
    const made = URL.createObjectURL(file);
    setAddress(made);
    return () => URL.revokeObjectURL(made);
  }, [file]);
  // What the browser cannot show is told of by the server.
  const hide = ({ currentTarget }: { currentTarget: HTMLImageElement }) => {
    currentTarget.hidden = true;
  };
  if (address) return <img key={address} class="ground" src={address} alt="" onError={hide} />;
  if (ground?.kind !== "outline" && ground?.kind !== "stored") return null;
  return (
    <svg class="ground" viewBox={`${frame.x} ${frame.y} ${frame.width} ${frame.height}`} aria-hidden="true">
      <path class="outline" d={ground.lines.map(linePath).join("")} />
    </svg>
  );
}
