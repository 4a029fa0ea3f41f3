/** The landmarks on the sheet: dragged, and deleted by a key. */
import type { RefObject } from "preact";
import { unit } from "../drawing/drawing";
import type { Point } from "../geometry/flat";
import { type Landmark, landmarks, move, remove } from "../state/corrections";
import { drawing } from "../state/drawing";
import { faulty } from "../state/faulty";
import { sheetPoint } from "./coordinates";

export function Pins({ svg }: { svg: RefObject<SVGSVGElement | null> }) {
  const one = unit(drawing.value.frame);
  return (
    <>
      {landmarks.value.map((landmark) =>
        landmark.at ? <Pin key={landmark.id} landmark={landmark} at={landmark.at} one={one} svg={svg} /> : null,
      )}
    </>
  );
}

interface Props {
  landmark: Landmark;
  at: Point;
  one: number;
  svg: RefObject<SVGSVGElement | null>;
}

/** How far an arrow key moves a landmark, in units of the sheet. */
const STEP = 5;

function Pin({ landmark: { id, vertex }, at: [x, y], one, svg }: Props) {
  const by: Record<string, Point> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
  return (
    <g
      class={`pin ${vertex === null ? "lacking" : ""} ${faulty.value.has(id) ? "faulty" : ""}`}
      role="button"
      tabindex={0}
      aria-label={`Landmark ${id} on the drawing; arrows move it, Delete removes it`}
      onPointerDown={(event) => {
        event.stopPropagation();
        event.currentTarget.setPointerCapture(event.pointerId);
      }}
      onPointerMove={(event) => {
        if (!event.currentTarget.hasPointerCapture(event.pointerId)) return;
        event.stopPropagation();
        move(id, { at: sheetPoint(svg.current as SVGSVGElement, event) });
      }}
      onKeyDown={(event) => {
        const way = by[event.key];
        if (way) move(id, { at: [x + way[0] * STEP * one, y + way[1] * STEP * one] });
        else if (event.key === "Delete" || event.key === "Backspace") remove(id);
        else return;
        event.preventDefault();
        event.stopPropagation();
      }}
    >
      <circle cx={x} cy={y} r={17 * one} />
      <text x={x} y={y + 8 * one} font-size={23 * one}>
        {id}
      </text>
    </g>
  );
}
