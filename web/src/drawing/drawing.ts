/** What is on the sheet. Drawings are never changed: every edit makes a new one. */
import type { Box, Point } from "../geometry/flat";

export interface Drawing {
  /** The part of the plane that the sheet shows; its coordinates are those of the sheet, y down. */
  frame: Box;
  /** A file below the strokes. */
  ground: Ground | null;
  strokes: Stroke[];
}

/** Places a pen went through, with its pressure from 0 to 1. */
export interface Stroke {
  points: [x: number, y: number, pressure: number][];
}

export type Ground =
  | { kind: "picture" | "svg"; file: Blob; name: string }
  /** An outline in JSON; on the sheet its y is turned down. */
  | { kind: "outline"; file: Blob; name: string; lines: Point[][] }
  /** A sketch that the server has, of which the lines around are known. */
  | { kind: "stored"; id: string; yUp: boolean; lines: Point[][] };

/** The sheet for drawing by hand. */
export const SHEET: Box = { x: 0, y: 0, width: 1000, height: 1000 };

export const EMPTY: Drawing = { frame: SHEET, ground: null, strokes: [] };

export const isEmpty = (drawing: Drawing) => drawing.ground === null && drawing.strokes.length === 0;

/** Whether y points up in the coordinates of the upload. */
export function isYUp({ ground, strokes }: Drawing): boolean {
  if (strokes.length > 0 || ground === null) return false;
  return ground.kind === "outline" || (ground.kind === "stored" && ground.yUp);
}

/** A point of the sheet as the upload has it, and the reverse. */
export const turned = ([x, y]: Point, yUp: boolean): Point => [x, yUp ? -y : y];

/** The unit of pen and marks: a thousandth of the longer side of the sheet. */
export const unit = ({ width, height }: Box) => Math.max(width, height) / 1000;

export const withStrokes = (drawing: Drawing, strokes: Stroke[]): Drawing => ({ ...drawing, strokes });

/** The stroke mirrored at the upright line through the middle of the sheet. */
export function mirrored(stroke: Stroke, frame: Box): Stroke {
  return { points: stroke.points.map(([x, y, pressure]) => [2 * frame.x + frame.width - x, y, pressure]) };
}
