/** A drawing as the server takes it. */
import { type Drawing, type Ground, unit } from "./drawing";
import { inkPath, linePath } from "./ink";

const SVG = "image/svg+xml";

/** The file of a drawing that is not stored yet: a file as it is, and where something was drawn on it, both as one. */
export async function fileOf(drawing: Drawing): Promise<Blob> {
  const { ground, strokes } = drawing;
  if (ground === null) return svg(drawing, "");
  if (ground.kind === "stored") return svg(drawing, lines(ground));
  if (strokes.length === 0) return ground.file;
  switch (ground.kind) {
    case "outline":
      return svg(drawing, lines(ground));
    case "svg":
      return onSvg(await ground.file.text(), drawing);
    case "picture":
      return onPicture(ground.file, drawing);
  }
}

const inks = ({ strokes, frame }: Drawing) => strokes.map((stroke) => inkPath(stroke, unit(frame)));

const lines = (ground: Ground & { kind: "outline" | "stored" }) =>
  ground.lines.map((line) => `<path d="${linePath(line)}"/>`).join("");

function svg(drawing: Drawing, below: string): Blob {
  const { x, y, width, height } = drawing.frame;
  const paths = inks(drawing).map((path) => `<path d="${path}"/>`);
  const outline = below && `<g fill="none" stroke="#000" stroke-width="${6 * unit(drawing.frame)}">${below}</g>`;
  const head = `<svg xmlns="http://www.w3.org/2000/svg" viewBox="${x} ${y} ${width} ${height}">`;
  return new Blob([`${head}${outline}${paths.join("")}</svg>`], { type: SVG });
}

function onSvg(text: string, drawing: Drawing): Blob {
  const document = new DOMParser().parseFromString(text, SVG);
  for (const path of inks(drawing)) {
    const element = document.createElementNS("http://www.w3.org/2000/svg", "path");
    element.setAttribute("d", path);
    document.documentElement.append(element);
  }
  return new Blob([new XMLSerializer().serializeToString(document)], { type: SVG });
}

async function onPicture(file: Blob, drawing: Drawing): Promise<Blob> {
  return painted(await createImageBitmap(file), (context) => {
    for (const path of inks(drawing)) context.fill(new Path2D(path));
  });
}

/** A picture as PNG, with what `paint` adds. */
export function painted(picture: ImageBitmap, paint: (context: CanvasRenderingContext2D) => void): Promise<Blob> {
  const canvas = document.createElement("canvas");
  [canvas.width, canvas.height] = [picture.width, picture.height];
  const context = canvas.getContext("2d") as CanvasRenderingContext2D;
  context.drawImage(picture, 0, 0);
  paint(context);
  return new Promise((resolve, reject) => {
    const taken = (blob: Blob | null) =>
      blob ? resolve(blob) : reject(new Error("the picture is too large to draw on"));
    canvas.toBlob(taken, "image/png");
  });
}
