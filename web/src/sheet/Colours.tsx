/** The colours of the figure on the sheet, behind the lines. */
import { useSignalEffect } from "@preact/signals";
import { useRef } from "preact/hooks";
import type { Box, Flat } from "../geometry/flat";
import { sketchColours } from "../state/colouring";
import { drawing } from "../state/drawing";
import { answer } from "../state/live";
import { posed } from "../state/posed";

/** Pixels along the longer side: they are smoothed when shown. */
const SIDE = 640;

export function Colours() {
  const canvas = useRef<HTMLCanvasElement>(null);
  useSignalEffect(() => {
    const flat = answer.value?.reading.flat;
    const points = posed.value?.drawing ?? flat?.points;
    if (canvas.current)
      paint(canvas.current, drawing.value.frame, flat && points && { ...flat, points }, sketchColours.value);
  });
  const state = !answer.value ? "none" : answer.value.reading.of !== drawing.value ? "past" : "";
  return <canvas ref={canvas} class={`colours ${state}`} aria-hidden="true" />;
}

function paint(canvas: HTMLCanvasElement, frame: Box, flat: Flat | undefined, colours: Uint8Array | null) {
  const scale = SIDE / Math.max(frame.width, frame.height);
  [canvas.width, canvas.height] = [Math.round(frame.width * scale), Math.round(frame.height * scale)];
  const context = canvas.getContext("2d", { willReadFrequently: true });
  if (!context || !flat || !colours) return;
  const picture = context.createImageData(canvas.width, canvas.height);
  for (let t = 0; t < flat.triangles.length; t += 3) {
    const corners = [0, 1, 2].map((i) => flat.triangles[t + i]);
    const places = corners.map((v) => [
      (flat.points[2 * v] - frame.x) * scale,
      (flat.points[2 * v + 1] - frame.y) * scale,
    ]);
    fill(picture, places, (i) => colours.subarray(3 * corners[i], 3 * corners[i] + 3));
  }
  context.putImageData(picture, 0, 0);
}

/** Paints one triangle, its corners' colours mixed between them. */
function fill(picture: ImageData, [a, b, c]: number[][], colour: (corner: number) => Uint8Array) {
  const twice = (b[0] - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (b[1] - a[1]);
  if (twice === 0) return;
  const [left, right] = [Math.min(a[0], b[0], c[0]), Math.max(a[0], b[0], c[0])];
  const [top, bottom] = [Math.min(a[1], b[1], c[1]), Math.max(a[1], b[1], c[1])];
  const colours = [colour(0), colour(1), colour(2)];
  for (let y = Math.max(0, Math.floor(top)); y < Math.min(picture.height, bottom); y++) {
    for (let x = Math.max(0, Math.floor(left)); x < Math.min(picture.width, right); x++) {
      const [px, py] = [x + 0.5, y + 0.5];
      const v = ((px - a[0]) * (c[1] - a[1]) - (c[0] - a[0]) * (py - a[1])) / twice;
      const w = ((b[0] - a[0]) * (py - a[1]) - (px - a[0]) * (b[1] - a[1])) / twice;
      const u = 1 - v - w;
      if (u < 0 || v < 0 || w < 0) continue;
      const pixel = 4 * (y * picture.width + x);
      for (let i = 0; i < 3; i++) {
        picture.data[pixel + i] = u * colours[0][i] + v * colours[1][i] + w * colours[2][i];
      }
      picture.data[pixel + 3] = 255;
    }
  }
}
