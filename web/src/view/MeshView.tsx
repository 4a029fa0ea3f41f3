/** The mesh, with the points that correspond over it. */
import { useSignal, useSignalEffect } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import { meshColours } from "../state/colouring";
import { place } from "../state/corrections";
import { hovered } from "../state/hover";
import { answer, chosen } from "../state/live";
import { mesh } from "../state/mesh";
import { posed } from "../state/posed";
import { tool } from "../state/tools";
import { asDrawn } from "./camera";
import { MeshMarks } from "./MeshMarks";
import { Stage } from "./stage";

/** How far the pointer may move between down and up for a click, in pixels. */
const CLICK = 5;

export function MeshView() {
  const canvas = useRef<HTMLCanvasElement>(null);
  const began = useRef<PointerEvent | null>(null);
  const stage = useSignal<Stage | null>(null);
  /** Counts the pictures, so that what lies over the mesh follows it. */
  const picture = useSignal(0);
  /** Where keys have moved the cross, in pixels. */
  const cross = useSignal<{ x: number; y: number } | null>(null);

  useEffect(() => {
    const element = canvas.current as HTMLCanvasElement;
    const made = new Stage(element, () => {
      picture.value++;
    });
    const watch = new ResizeObserver(() => made.resize());
    watch.observe(element);
    stage.value = made;
    return () => {
      watch.disconnect();
      made.dispose();
    };
  }, []);

  useSignalEffect(() => {
    if (mesh.value) stage.value?.show(mesh.value.surface);
  });
  useSignalEffect(() => {
    const positions = posed.value?.positions ?? mesh.value?.surface.positions;
    if (positions) stage.value?.move(positions);
  });
  useSignalEffect(() => {
    if (meshColours.value) stage.value?.colour(meshColours.value);
  });
  useSignalEffect(() => {
    if (asDrawn.value) stage.value?.look(asDrawn.value.view, asDrawn.value.isFlown);
  });

  return (
    <div class="mesh-view">
      <canvas
        ref={canvas}
        class={tool.value}
        role="application"
        aria-label={label()}
        aria-describedby="mesh-keys"
        tabIndex={0}
        {...pointer(stage.value, began)}
        onKeyDown={(event) => onKey(event, stage.value, cross)}
        onBlur={() => {
          cross.value = null;
        }}
      />
      {stage.value && <MeshMarks stage={stage.value} picture={picture.value} cross={cross.value} />}
    </div>
  );
}

function label(): string {
  const name = mesh.value?.document.name ?? "Mesh";
  if (!answer.value) return `${name}, not matched yet`;
  return chosen.value === null ? `${name} in the colours of the drawing` : `${name}, alternative ${chosen.value + 1}`;
}

function pointer(stage: Stage | null, began: { current: PointerEvent | null }) {
  let isPicking = false;
  const pick = (event: PointerEvent) => stage?.pick(event.offsetX, event.offsetY) ?? null;
  return {
    onPointerDown: (event: PointerEvent) => {
      began.current = event;
    },
    onPointerUp: (event: PointerEvent) => {
      const from = began.current;
      began.current = null;
      const way = from ? Math.hypot(event.clientX - from.clientX, event.clientY - from.clientY) : Infinity;
      if (way > CLICK || tool.value !== "landmark") return;
      const vertex = pick(event);
      if (vertex !== null) place({ vertex });
    },
    onPointerMove: (event: PointerEvent) => {
      if (began.current || isPicking || event.pointerType === "touch") return;
      isPicking = true;
      requestAnimationFrame(() => {
        isPicking = false;
        const vertex = pick(event);
        hovered.value = vertex === null ? null : { vertex };
      });
    },
    onPointerLeave: () => {
      hovered.value = null;
    },
  };
}

/** How far an arrow turns the mesh, in turns, and moves the cross, in pixels. */
const TURN = 1 / 36;
const STEP = 12;

const ARROWS: Record<string, [number, number]> = {
  ArrowLeft: [-1, 0],
  ArrowRight: [1, 0],
  ArrowUp: [0, -1],
  ArrowDown: [0, 1],
};

type Cross = { value: { x: number; y: number } | null };

function onKey(event: KeyboardEvent, stage: Stage | null, cross: Cross) {
  if (!stage || event.ctrlKey || event.metaKey || event.altKey) return;
  const arrow = ARROWS[event.key];
  if (arrow && tool.value === "landmark") moveCross(event, arrow, cross, stage);
  else if (arrow) stage.turn(-TURN * arrow[0], -TURN * arrow[1]);
  else if (event.key === "+" || event.key === "=") stage.zoom(1 / 1.15);
  else if (event.key === "-") stage.zoom(1.15);
  else if ((event.key === "Enter" || event.key === " ") && tool.value === "landmark") {
    const vertex = cross.value && stage.pick(cross.value.x, cross.value.y);
    if (typeof vertex === "number") place({ vertex });
  } else return;
  event.preventDefault();
}

function moveCross(event: KeyboardEvent, [dx, dy]: [number, number], cross: Cross, stage: Stage) {
  const { clientWidth, clientHeight } = event.currentTarget as HTMLCanvasElement;
  const { x, y } = cross.value ?? { x: clientWidth / 2, y: clientHeight / 2 };
  const step = event.shiftKey ? STEP / 6 : STEP;
  const inside = (value: number, side: number) => Math.min(side, Math.max(0, value));
  cross.value = { x: inside(x + step * dx, clientWidth), y: inside(y + step * dy, clientHeight) };
  const vertex = stage.pick(cross.value.x, cross.value.y);
  hovered.value = vertex === null ? null : { vertex };
}
