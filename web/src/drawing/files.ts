/** Files that people bring. */
import type { Outline } from "../api/types";
import { type Box, boxOf, type Point } from "../geometry/flat";
import { type Drawing, SHEET, type Stroke } from "./drawing";
import { extended } from "./stroke";
import { painted } from "./upload";

export const DRAWING_FILES = "image/*,application/json,.svg,.json";
export const MESH_FILES = ".obj,.off,.ply,.stl,.glb,.gltf";

export const isMesh = (name: string) => MESH_FILES.split(",").some((ending) => name.toLowerCase().endsWith(ending));

/**
 * The drawing in a file.
 *
 * @throws {Error} where this is no drawing, in words.
 */
export async function drawingOf(file: File): Promise<Drawing> {
  const { name } = file;
  if (file.type === "application/json" || name.toLowerCase().endsWith(".json")) return ofJson(file);
  if (file.type === "image/svg+xml" || name.toLowerCase().endsWith(".svg")) return ofSvg(file);
  if (file.type.startsWith("image/")) return ofPicture(file);
  throw new Error(`${name} is no drawing: choose an SVG, a picture or an outline as JSON`);
}

async function ofPicture(file: File): Promise<Drawing> {
  const picture = await createImageBitmap(file).catch(() => null);
  const isTaken = file.type === "image/png" || file.type === "image/jpeg";
  // What the browser cannot read the server refuses with a reason.
  if (!picture && !isTaken) throw new Error(`${file.name} is a picture of a kind that this browser does not read`);
  const frame = picture ? { x: 0, y: 0, width: picture.width, height: picture.height } : SHEET;
  const taken = picture && !isTaken ? await painted(picture, () => {}) : file.slice(0, file.size, file.type);
  return { frame, ground: { kind: "picture", file: taken, name: file.name }, strokes: [] };
}

async function ofSvg(file: File): Promise<Drawing> {
  const root = new DOMParser().parseFromString(await file.text(), "image/svg+xml").documentElement;
  const numbers =
    root
      .getAttribute("viewBox")
      ?.trim()
      .split(/[\s,]+/)
      .map(Number) ?? [];
  const side = (name: string) => Number.parseFloat(root.getAttribute(name) ?? "") || SHEET.width;
  const [x, y, width, height] = numbers.length === 4 ? (numbers as [number, number, number, number]) : [0, 0, 0, 0];
  const frame =
    width > 0 && height > 0 ? { x, y, width, height } : { x: 0, y: 0, width: side("width"), height: side("height") };
  const taken = file.slice(0, file.size, "image/svg+xml");
  return { frame, ground: { kind: "svg", file: taken, name: file.name }, strokes: [] };
}

async function ofJson(file: File): Promise<Drawing> {
  const lines = linesOf(await file.text());
  if (!lines) throw new Error(`${file.name} is no outline: it is JSON of the form {"outline": [[x, y], …]}, y up`);
  const taken = file.slice(0, file.size, "application/json");
  return { frame: framed(lines), ground: { kind: "outline", file: taken, name: file.name, lines }, strokes: [] };
}

/** The lines of an outline in JSON as they lie on the sheet, y down. */
function linesOf(text: string): Point[][] | null {
  try {
    const outline = JSON.parse(text) as Outline;
    const lines = [outline.outline, ...(outline.holes ?? [])].map((line) => line.map(([x, y]): Point => [x, -y]));
    return lines.flat(2).every(Number.isFinite) ? lines : null;
  } catch {
    return null;
  }
}

/** The box around lines with a margin. */
function framed(lines: Point[][]): Box {
  const { x, y, width, height } = boxOf(lines.flat(2) as number[]);
  const margin = 0.08 * Math.max(width, height);
  return { x: x - margin, y: y - margin, width: width + 2 * margin, height: height + 2 * margin };
}

/** How much of the sheet an example fills. */
const FILLED = 0.8;

/** The outline of an example as strokes on the sheet for drawing by hand. */
export function strokesOf(outline: Outline): Stroke[] {
  const lines = [outline.outline, ...(outline.holes ?? [])];
  const box = boxOf(outline.outline.flat() as number[]);
  const scale = (FILLED * SHEET.width) / Math.max(box.width, box.height);
  const placed = ([x, y]: number[]): Stroke["points"][number] => [
    SHEET.width / 2 + scale * (x - box.x - box.width / 2),
    SHEET.height / 2 - scale * (y - box.y - box.height / 2),
    0.5,
  ];
  return lines.map((line) => {
    const closed = [...line, line[0] as number[]].map(placed);
    return { points: closed.reduce<Stroke["points"]>((points, point) => extended(points, point, 1), []) };
  });
}
