/** What lies over the mesh: the point looked at, the landmarks, the cross that keys move. */
import { type Landmark, landmarks, move, remove } from "../state/corrections";
import { faulty } from "../state/faulty";
import { twin } from "../state/hover";
import type { Stage } from "./stage";

interface Props {
  stage: Stage;
  /** The number of the picture: with a new one the marks are put anew. */
  picture: number;
  cross: { x: number; y: number } | null;
}

export function MeshMarks({ stage, cross }: Props) {
  return (
    <svg class="mesh-marks" role="group" aria-label="Marks on the mesh">
      {twin.value && <Twin {...stage.place(twin.value.vertex)} />}
      {landmarks.value.map((landmark) =>
        landmark.vertex === null ? null : (
          <Pin key={landmark.id} landmark={landmark} vertex={landmark.vertex} stage={stage} />
        ),
      )}
      {cross && <path class="cursor" d={`M${cross.x - 10} ${cross.y}h20M${cross.x} ${cross.y - 10}v20`} />}
    </svg>
  );
}

const Twin = ({ x, y, isBehind }: { x: number; y: number; isBehind: boolean }) => (
  <circle class={`twin ${isBehind ? "behind" : ""}`} cx={x} cy={y} r={7} />
);

function Pin({ landmark: { id, at }, vertex, stage }: { landmark: Landmark; vertex: number; stage: Stage }) {
  const { x, y, isBehind } = stage.place(vertex);
  const states = `${at === null ? "lacking" : ""} ${isBehind ? "behind" : ""} ${faulty.value.has(id) ? "faulty" : ""}`;
  return (
    <g
      class={`pin ${states}`}
      role="button"
      tabindex={0}
      aria-label={`Landmark ${id} on the mesh, Delete removes it`}
      onPointerDown={(event) => event.currentTarget.setPointerCapture(event.pointerId)}
      onPointerMove={(event) => {
        if (!event.currentTarget.hasPointerCapture(event.pointerId)) return;
        const box = (event.currentTarget.ownerSVGElement as SVGSVGElement).getBoundingClientRect();
        const under = stage.pick(event.clientX - box.left, event.clientY - box.top);
        if (under !== null) move(id, { vertex: under });
      }}
      onKeyDown={(event) => {
        if (event.key === "Delete" || event.key === "Backspace") remove(id);
      }}
    >
      <circle cx={x} cy={y} r={11} />
      <text x={x} y={y + 4.5} font-size={13}>
        {id}
      </text>
    </g>
  );
}
