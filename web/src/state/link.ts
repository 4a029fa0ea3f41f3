/** A link that opens the same state: in the hash, so that it goes to no server. */
import * as shapes from "../api/shapes";
import { type Drawing, isYUp, type Stroke } from "../drawing/drawing";
import { type Box, flatOf } from "../geometry/flat";
import { type Kept, now } from "./keep";
import { answer, reading } from "./live";
import { give } from "./tidy";

/** What a link holds: the state, with the drawing by its strokes where it is drawn by hand, else by its id. */
type Linked = Omit<Kept, "drawing"> & { frame: Box } & ({ strokes: Stroke[] } | { sketch: string; yUp: boolean });

/** The address of the state of now; nothing where the server has not read the drawing. */
export async function link(): Promise<string | null> {
  const { drawing, ...rest } = now();
  const id = reading.value?.of === drawing ? reading.value.document.id : null;
  if (drawing.ground !== null && id === null) return null;
  if (id) give(id);
  if (answer.value) give(answer.value.match.id);
  const drawn =
    drawing.ground === null ? { strokes: drawing.strokes.map(rounded) } : { sketch: id as string, yUp: isYUp(drawing) };
  const linked: Linked = { ...rest, frame: drawing.frame, ...drawn };
  return `${location.origin}${location.pathname}#${await packed(JSON.stringify(linked))}`;
}

/** The state that the address of this page holds; nothing where it holds none that can be read. */
export async function linked(): Promise<Kept | null> {
  const hash = location.hash.slice(1);
  if (!hash) return null;
  try {
    const { frame, ...state } = JSON.parse(await unpacked(hash)) as Linked;
    const lists = [state.landmarks, state.handles, state.frames, "strokes" in state ? state.strokes : []];
    if (!lists.every(Array.isArray)) return null;
    return { ...state, drawing: await drawingOf(frame, state) };
  } catch {
    return null;
  }
}

async function drawingOf(
  frame: Box,
  linked: { strokes: Stroke[] } | { sketch: string; yUp: boolean },
): Promise<Drawing> {
  if ("strokes" in linked) return { frame, ground: null, strokes: linked.strokes };
  const { outlines } = flatOf(await shapes.sketchGeometry(linked.sketch), linked.yUp);
  return { frame, ground: { kind: "stored", id: linked.sketch, yUp: linked.yUp, lines: outlines }, strokes: [] };
}

function rounded({ points }: Stroke): Stroke {
  const round = (x: number) => Math.round(100 * x) / 100;
  return { points: points.map(([x, y, pressure]) => [round(x), round(y), round(pressure)]) };
}

async function packed(text: string): Promise<string> {
  const bytes = await through(new TextEncoder().encode(text), new CompressionStream("deflate-raw"));
  const binary = Array.from(bytes, (byte) => String.fromCharCode(byte)).join("");
  return btoa(binary).replaceAll("+", "-").replaceAll("/", "_").replaceAll("=", "");
}

async function unpacked(text: string): Promise<string> {
  const binary = atob(text.replaceAll("-", "+").replaceAll("_", "/"));
  const bytes = Uint8Array.from(binary, (character) => character.charCodeAt(0));
  return new TextDecoder().decode(await through(bytes, new DecompressionStream("deflate-raw")));
}

async function through(bytes: Uint8Array<ArrayBuffer>, stream: CompressionStream | DecompressionStream) {
  const answer = new Response(new Blob([bytes]).stream().pipeThrough(stream));
  return new Uint8Array(await answer.arrayBuffer());
}
