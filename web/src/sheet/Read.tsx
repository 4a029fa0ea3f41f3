/** What was read of the drawing: the figure's outline, what was mended or is missing, other figures, the point looked at. */
import type { ProblemFault } from "../api/types";
import { type Drawing, isYUp, turned, unit } from "../drawing/drawing";
import { linePath } from "../drawing/ink";
import { isNear, looseEnds } from "../drawing/stroke";
import { type Box, boxOf, type Point } from "../geometry/flat";
import { drawing, figure } from "../state/drawing";
import { twin } from "../state/hover";
import { type Reading, reading, stage } from "../state/live";
import { tool } from "../state/tools";
import { underway } from "./pencil";

export function Read() {
  const one = unit(drawing.value.frame);
  const read = reading.value;
  const isOfNow = read?.of === drawing.value && !underway.value;
  // Of an outline that is still open nothing is to be seen but its ends.
  const isBegun = stage.value.kind === "open" && stage.value.isTaken;
  return (
    <>
      {isOfNow && !isBegun && <Figure read={read} />}
      {underway.value && tool.value === "pen" && <Closing of={underway.value} />}
      {stage.value.kind === "open" && !underway.value && <Open of={drawing.value} faults={stage.value.faults} />}
      {twin.value && !underway.value && <circle class="twin" cx={twin.value.at[0]} cy={twin.value.at[1]} r={9 * one} />}
    </>
  );
}

function Figure({ read }: { read: Reading }) {
  const one = unit(read.of.frame);
  const yUp = isYUp(read.of);
  const marks = read.document.warnings.filter((warning) => warning.point || warning.box);
  return (
    <>
      <path class="read" d={read.flat.outlines.map(linePath).join("")} />
      {marks.map(({ code, detail, point, box }) => (
        <g key={`${code}${point ?? box}`} class={`mark ${code}`}>
          <title>{detail}</title>
          {point ? (
            <Ring at={turned(point as unknown as Point, yUp)} r={12 * one} />
          ) : (
            <Rim box={boxOnSheet(box, yUp)} />
          )}
        </g>
      ))}
      {read.document.figures && read.document.figures.length > 1 && (
        <Figures boxes={read.document.figures.map(({ box }) => boxOnSheet(box, yUp))} one={one} />
      )}
    </>
  );
}

/** Every figure of the drawing: a click takes it. */
function Figures({ boxes, one }: { boxes: Box[]; one: number }) {
  return (
    <>
      {boxes.map((box, i) => (
        <g
          key={`${box.x} ${box.y}`}
          class="figure"
          role="button"
          tabindex={0}
          aria-pressed={figure.value === i}
          aria-label={`Figure ${i + 1} of the drawing`}
          onPointerDown={(event) => event.stopPropagation()}
          onClick={() => {
            figure.value = i;
          }}
          onKeyDown={(event) => {
            if (event.key !== "Enter" && event.key !== " ") return;
            event.preventDefault();
            event.stopPropagation();
            figure.value = i;
          }}
        >
          <Rim box={box} />
          <rect class="tab" x={box.x} y={box.y} width={54 * one} height={44 * one} rx={6 * one} />
          <text x={box.x + 27 * one} y={box.y + 32 * one} font-size={28 * one}>
            {i + 1}
          </text>
        </g>
      ))}
    </>
  );
}

/** Where a drawing that is no figure yet may be open. */
function Open({ of, faults }: { of: Drawing; faults: ProblemFault[] }) {
  const one = unit(of.frame);
  return (
    <g class="mark open">
      {[...looseEnds(of.strokes, one), ...named(faults, isYUp(of))].map(([x, y]) => (
        <Ring key={`${x} ${y}`} at={[x, y]} r={16 * one} />
      ))}
    </g>
  );
}

/** Points of a stroke from which on it may be a whole outline. */
const LONG = 40;

/** Where a stroke under way began, and whether it would be closed if the pen were lifted now. */
function Closing({ of }: { of: Drawing }) {
  const one = unit(of.frame);
  const points = of.strokes.at(-1)?.points ?? [];
  const [first, last] = [points[0], points.at(-1)];
  if (!first || !last || points.length < LONG) return null;
  const [start, end]: Point[] = [
    [first[0], first[1]],
    [last[0], last[1]],
  ];
  const isClosed = isNear(start as Point, end as Point, one);
  return (
    <g class={`mark open ${isClosed ? "closed" : ""}`}>
      <Ring at={start as Point} r={16 * one} />
    </g>
  );
}

/** The points that faults name as their places: `point (x, y)` in the coordinates of the upload. */
function named(faults: ProblemFault[], yUp: boolean): Point[] {
  return faults.flatMap(({ place }) => {
    const [, x, y] = /^point \((\S+), (\S+)\)$/.exec(place ?? "") ?? [];
    return x && y ? [turned([Number(x), Number(y)], yUp)] : [];
  });
}

const Ring = ({ at: [x, y], r }: { at: Point; r: number }) => <circle cx={x} cy={y} r={r} />;

const Rim = ({ box: { x, y, width, height } }: { box: Box }) => <rect x={x} y={y} width={width} height={height} />;

function boxOnSheet(corners: number[][] | null | undefined, yUp: boolean): Box {
  return boxOf((corners ?? []).flatMap((corner) => [...turned(corner as unknown as Point, yUp)]));
}
