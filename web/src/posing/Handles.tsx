/** The handles on the sheet: set by a click or a drag, dragged, turned by their tips, deleted. */
import { useSignal } from "@preact/signals";
import type { RefObject } from "preact";
import { unit } from "../drawing/drawing";
import type { Point } from "../geometry/flat";
import { affine, applied, type Handle, type Move, pivot, STAY } from "../geometry/handles";
import { sheetPoint } from "../sheet/coordinates";
import { drawing } from "../state/drawing";
import { add, addPoint, handles, isPlacing, move, moves, remove, replace } from "../state/handles";
import { pause, shown } from "./playing";
import { taken } from "./taken";

/** How far the pointer has to go for a bone, and the tip of a point stands off, in units of the sheet. */
const LONG = 25;
const TIP = 55;
/** How far an arrow key moves a handle, in units of the sheet, and turns it, in degrees. */
const STEP = 5;
const TURN = 5;

const ARROWS: Record<string, Point> = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };

interface Props {
  svg: RefObject<SVGSVGElement | null>;
}

export default function Handles({ svg }: Props) {
  const { frame } = drawing.value;
  return (
    <g class={`handles ${isPlacing.value ? "placing" : ""}`}>
      <Placing svg={svg} />
      {!taken.value &&
        handles.value.map((handle, i) => <Held key={i} number={i} handle={handle} one={unit(frame)} svg={svg} />)}
    </g>
  );
}

/** Takes the pointer on the sheet: a click sets a point, a drag a bone. */
function Placing({ svg }: Props) {
  const begun = useSignal<{ from: Point; to: Point } | null>(null);
  const { x, y, width, height } = drawing.value.frame;
  const one = unit(drawing.value.frame);
  const at = (event: PointerEvent) => sheetPoint(svg.current as SVGSVGElement, event);
  const isLong = begun.value !== null && distance(begun.value.from, begun.value.to) > LONG * one;
  return (
    <>
      <rect
        class="catch"
        x={x}
        y={y}
        width={width}
        height={height}
        onPointerDown={(event) => {
          event.stopPropagation();
          if (!isPlacing.value || event.button !== 0) return;
          event.currentTarget.setPointerCapture(event.pointerId);
          begun.value = { from: at(event), to: at(event) };
        }}
        onPointerMove={(event) => {
          if (begun.value) begun.value = { ...begun.value, to: at(event) };
        }}
        onPointerUp={() => {
          const set = begun.value;
          begun.value = null;
          if (set) isLong ? add({ kind: "bone", ...set }) : addPoint(set.from);
        }}
        onPointerCancel={() => {
          begun.value = null;
        }}
      />
      {begun.value && isLong && <path class="bone" d={line(begun.value.from, begun.value.to)} />}
    </>
  );
}

interface HeldProps extends Props {
  number: number;
  handle: Handle;
  one: number;
}

function Held({ number, handle, one, svg }: HeldProps) {
  const now = isPlacing.value ? STAY : (shown.value[number] ?? STAY);
  const map = affine(handle, now);
  const [base, tip] = [applied(map, pivot(handle)), applied(map, tipOf(handle, one))];
  const isBone = handle.kind === "bone";
  const name = `${isBone ? "Bone" : "Point"} ${number + 1}`;
  const dragged = (drag: (to: Point) => void) => ({
    onPointerDown: (event: PointerEvent & { currentTarget: SVGElement }) => {
      event.stopPropagation();
      pause();
      event.currentTarget.setPointerCapture(event.pointerId);
    },
    onPointerMove: (event: PointerEvent & { currentTarget: SVGElement }) => {
      if (event.currentTarget.hasPointerCapture(event.pointerId)) drag(sheetPoint(svg.current as SVGSVGElement, event));
    },
  });
  return (
    <g class={handle.kind}>
      {(isBone || !isPlacing.value) && (
        <>
          <path class={isBone ? "bone" : "arm"} d={line(base, tip)} />
          <circle class="tip" cx={tip[0]} cy={tip[1]} r={9 * one} {...dragged((to) => dragTip(number, handle, to))} />
        </>
      )}
      <circle
        class="base"
        cx={base[0]}
        cy={base[1]}
        r={14 * one}
        role="button"
        tabindex={0}
        aria-label={`${name}; arrows move it, with Shift they turn it, Delete removes it`}
        onKeyDown={(event) => onKey(event, number, handle, one)}
        {...dragged((to) => dragBase(number, handle, to))}
      />
    </g>
  );
}

const distance = (a: Point, b: Point) => Math.hypot(b[0] - a[0], b[1] - a[1]);
const plus = (a: Point, b: Point): Point => [a[0] + b[0], a[1] + b[1]];
const minus = (a: Point, b: Point): Point => [a[0] - b[0], a[1] - b[1]];
const line = (from: Point, to: Point) => `M${from[0]} ${from[1]}L${to[0]} ${to[1]}`;

/** Where the tip of a handle is at rest. */
const tipOf = (handle: Handle, one: number): Point =>
  handle.kind === "bone" ? handle.to : plus(handle.at, [0, -TIP * one]);

/** The direction from one point to another, in degrees counter-clockwise as it is seen. */
const direction = (from: Point, to: Point) => (Math.atan2(from[1] - to[1], to[0] - from[0]) * 180) / Math.PI;

/** The same direction, by the turn that is nearest to one of before. */
const unwound = (degrees: number, before: number) => degrees + 360 * Math.round((before - degrees) / 360);

const moveOf = (number: number): Move => moves.value[number] ?? STAY;

function dragBase(number: number, handle: Handle, to: Point) {
  if (!isPlacing.value) move(number, { ...moveOf(number), by: minus(to, pivot(handle)) });
  else replace(number, handle.kind === "point" ? { ...handle, at: to } : { ...handle, from: to });
}

function dragTip(number: number, handle: Handle, to: Point) {
  if (isPlacing.value) {
    if (handle.kind === "bone") replace(number, { ...handle, to });
    return;
  }
  const { degrees, by } = moveOf(number);
  const at = pivot(handle);
  const turned = direction(plus(at, by), to) - direction(at, tipOf(handle, 1));
  move(number, { degrees: unwound(turned, degrees), by });
}

function onKey(event: KeyboardEvent, number: number, handle: Handle, one: number) {
  const arrow = ARROWS[event.key];
  if (arrow) step(number, handle, [arrow[0] * STEP * one, arrow[1] * STEP * one], event.shiftKey);
  else if (event.key === "Delete" || event.key === "Backspace") remove(number);
  else return;
  event.preventDefault();
  event.stopPropagation();
}

function step(number: number, handle: Handle, way: Point, isTurn: boolean) {
  pause();
  if (isPlacing.value) {
    const moved = handle.kind === "point" ? { ...handle, at: plus(handle.at, way) } : shifted(handle, way);
    return replace(number, moved);
  }
  const { degrees, by } = moveOf(number);
  const turn = TURN * (way[0] > 0 || way[1] > 0 ? -1 : 1);
  move(number, isTurn ? { degrees: degrees + turn, by } : { degrees, by: plus(by, way) });
}

const shifted = (bone: Handle & { kind: "bone" }, way: Point): Handle => ({
  ...bone,
  from: plus(bone.from, way),
  to: plus(bone.to, way),
});
