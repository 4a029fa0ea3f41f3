/** The strokes. */
import { memo } from "preact/compat";
import { type Stroke, unit } from "../drawing/drawing";
import { inkPath } from "../drawing/ink";
import { drawing } from "../state/drawing";
import { underway } from "./pencil";

export function Ink() {
  const { strokes, frame } = underway.value ?? drawing.value;
  return (
    <g class="ink">
      {strokes.map((stroke, i) => (
        <Line key={i} stroke={stroke} unit={unit(frame)} />
      ))}
    </g>
  );
}

const Line = memo(({ stroke, unit }: { stroke: Stroke; unit: number }) => <path d={inkPath(stroke, unit)} />);
