/** A matrix as a heat map, its values told on hovering and by arrow keys. */
import { useSignal } from "@preact/signals";
import { useEffect, useRef } from "preact/hooks";
import type { Matrix } from "../api/types";
import { signed } from "../colour/maps";
import { bytes } from "../colour/oklab";
import { answer } from "../state/live";

const MATRICES = {
  c: { name: "C", meaning: "the functional map that was found" },
  initial: { name: "C⁰", meaning: "the least-squares solution it started from" },
  weights: { name: "W", meaning: "the weights: small where C is expected to be large" },
} as const;

type Which = keyof typeof MATRICES;

export function HeatMaps() {
  const which = useSignal<Which>("c");
  const result = answer.value?.result;
  if (!result) return <p class="hint">There is no answer yet.</p>;
  const matrix = { c: result.c, initial: result.intermediate.initial_c, weights: result.intermediate.weights }[
    which.value
  ];
  return (
    <>
      <div class="group" role="group" aria-label="Matrix">
        {Object.entries(MATRICES).map(([key, { name }]) => (
          <button
            key={key}
            type="button"
            aria-pressed={which.value === key}
            onClick={() => {
              which.value = key as Which;
            }}
          >
            {name}
          </button>
        ))}
      </div>
      <p class="hint">
        {MATRICES[which.value].name}: {MATRICES[which.value].meaning}. A row per eigenfunction of the mesh, a column per
        eigenfunction of the sketch; orange above 0, blue below.
      </p>
      <HeatMap matrix={matrix} name={MATRICES[which.value].name} />
    </>
  );
}

function HeatMap({ matrix: { rows, columns, values }, name }: { matrix: Matrix; name: string }) {
  const canvas = useRef<HTMLCanvasElement>(null);
  const cell = useSignal({ row: 0, column: 0 });
  useEffect(() => paint(canvas.current, rows, columns, values), [values]);
  const row = Math.min(rows - 1, cell.value.row);
  const column = Math.min(columns - 1, cell.value.column);
  const told = `${name}(${row + 1}, ${column + 1}) = ${values[row]?.[column]?.toPrecision(5)}`;
  return (
    <div class="heat-map">
      <div class="cells" style={{ "aspect-ratio": `${columns} / ${rows}` }}>
        <canvas ref={canvas} aria-hidden="true" />
        <button
          type="button"
          class="over"
          aria-label={`${told}. Arrow keys go to other entries.`}
          onPointerMove={({ offsetX, offsetY, currentTarget: { clientWidth, clientHeight } }) => {
            cell.value = {
              row: within(Math.floor((offsetY / clientHeight) * rows), rows),
              column: within(Math.floor((offsetX / clientWidth) * columns), columns),
            };
          }}
          onKeyDown={(event) => {
            const [down, right] = ARROWS[event.key] ?? [0, 0];
            if (!down && !right) return;
            event.preventDefault();
            cell.value = { row: within(row + down, rows), column: within(column + right, columns) };
          }}
        />
        <span
          class="cell"
          style={{
            left: `${(100 * column) / columns}%`,
            top: `${(100 * row) / rows}%`,
            width: `${100 / columns}%`,
            height: `${100 / rows}%`,
          }}
        />
      </div>
      <output aria-live="polite">{told}</output>
    </div>
  );
}

const ARROWS: Record<string, [number, number]> = {
  ArrowUp: [-1, 0],
  ArrowDown: [1, 0],
  ArrowLeft: [0, -1],
  ArrowRight: [0, 1],
};

const within = (index: number, count: number) => Math.min(count - 1, Math.max(0, index));

function paint(canvas: HTMLCanvasElement | null, rows: number, columns: number, values: number[][]) {
  const context = canvas?.getContext("2d");
  if (!canvas || !context) return;
  [canvas.width, canvas.height] = [columns, rows];
  const largest = Math.max(...values.flat().map(Math.abs)) || 1;
  const pixels = values.flat().flatMap((value) => [...bytes(signed(value / largest)), 255]);
  context.putImageData(new ImageData(Uint8ClampedArray.from(pixels), columns, rows), 0, 0);
}
