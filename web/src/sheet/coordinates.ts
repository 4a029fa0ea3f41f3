/** Between the pointer and the sheet. */
import type { Point } from "../geometry/flat";

/** The place of the sheet under a point of the window. */
export function sheetPoint(svg: SVGSVGElement, { clientX, clientY }: { clientX: number; clientY: number }): Point {
  const matrix = svg.getScreenCTM();
  if (!matrix) return [0, 0];
  const { x, y } = new DOMPoint(clientX, clientY).matrixTransform(matrix.inverse());
  return [x, y];
}
