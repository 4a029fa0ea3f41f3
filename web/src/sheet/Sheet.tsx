/** The sheet: what is drawn, what was read of it, and the points that correspond. */
import { useComputed } from "@preact/signals";
import type { RefObject } from "preact";
import { lazy, Suspense } from "preact/compat";
import { useRef } from "preact/hooks";
import { unit } from "../drawing/drawing";
import { place } from "../state/corrections";
import { drawing } from "../state/drawing";
import { hovered } from "../state/hover";
import { symmetric, tool } from "../state/tools";
import { Colours } from "./Colours";
import { sheetPoint } from "./coordinates";
import { Ghost } from "./Ghost";
import { Ground } from "./Ground";
import { Ink } from "./Ink";
import { cursor, onKey } from "./keyboard";
import { Pins } from "./Pins";
import * as pencil from "./pencil";
import { Read } from "./Read";

const Handles = lazy(() => import("../posing/Handles"));

export function Sheet() {
  const svg = useRef<SVGSVGElement>(null);
  const active = useRef<number | null>(null);
  const frame = useComputed(() => drawing.value.frame).value;
  const { x, y, width, height } = frame;
  return (
    <div class="paper" style={{ "--ratio": width / height }}>
      <Ground />
      <Colours />
      <svg
        ref={svg}
        class={`sheet ${tool.value}`}
        viewBox={`${x} ${y} ${width} ${height}`}
        role="application"
        aria-label="Sheet to draw on"
        aria-describedby="sheet-keys"
        tabindex={0}
        onKeyDown={onKey}
        onBlur={() => {
          cursor.value = null;
          pencil.lift();
        }}
        {...pointer(svg, active)}
      >
        {symmetric.value && <path class="axis" d={`M${x + width / 2} ${y}v${height}`} />}
        <Ghost />
        <Ink />
        <Read />
        <Pins svg={svg} />
        {tool.value === "pose" && (
          <Suspense fallback={null}>
            <Handles svg={svg} />
          </Suspense>
        )}
        {cursor.value && <Cross at={cursor.value} size={12 * unit(frame)} />}
      </svg>
    </div>
  );
}

const Cross = ({ at: [x, y], size }: { at: readonly [number, number]; size: number }) => (
  <path class="cursor" d={`M${x - size} ${y}h${2 * size}M${x} ${y - size}v${2 * size}`} />
);

/** Pressure of pens; mice and fingers press evenly. */
const pressure = (event: PointerEvent) => (event.pointerType === "pen" ? event.pressure : 0.5);

/** What the pointer does; one finger or pen draws at a time. */
function pointer(svg: RefObject<SVGSVGElement | null>, active: { current: number | null }) {
  const at = (event: PointerEvent) => sheetPoint(svg.current as SVGSVGElement, event);
  return {
    onPointerDown: (event: PointerEvent) => {
      if (active.current !== null || event.button !== 0 || tool.value === "pose") return;
      cursor.value = null;
      if (tool.value === "landmark") return place({ at: at(event) });
      active.current = event.pointerId;
      svg.current?.setPointerCapture(event.pointerId);
      pencil.down(at(event), pressure(event));
    },
    onPointerMove: (event: PointerEvent) => {
      if (event.pointerId === active.current) {
        const samples = event.getCoalescedEvents?.() ?? [];
        for (const sample of samples.length > 0 ? samples : [event]) pencil.move(at(sample), pressure(sample));
      } else if (active.current === null) {
        hovered.value = { at: at(event) };
      }
    },
    onPointerUp: (event: PointerEvent) => {
      if (event.pointerId !== active.current) return;
      active.current = null;
      pencil.lift();
    },
    onPointerCancel: () => {
      active.current = null;
      pencil.abandon();
    },
    onPointerLeave: () => {
      hovered.value = null;
    },
  };
}
