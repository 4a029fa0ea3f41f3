/** Drawing on the sheet as a hand does, and files to open. */
import type { Locator, Page } from "@playwright/test";
import { expect } from "./server";

type Point = [number, number];

/** The outline of an example creature on the sheet, in thousandths of its side. */
export async function outline(page: Page, creature: string): Promise<Point[]> {
  const answer = await page.request.get(`/v1/examples/${creature}/sketch`, { headers: { accept: "application/json" } });
  const points: Point[] = (await answer.json()).outline;
  const [xs, ys] = [points.map(([x]) => x), points.map(([, y]) => y)];
  const [left, right, low, high] = [Math.min(...xs), Math.max(...xs), Math.min(...ys), Math.max(...ys)];
  const scale = 800 / Math.max(right - left, high - low);
  return points.map(([x, y]) => [500 + scale * (x - (left + right) / 2), 500 - scale * (y - (low + high) / 2)]);
}

/** Where places of the sheet are in the window. */
async function inWindow(page: Page): Promise<(at: Point) => Point> {
  const box = await page.locator("svg.sheet").boundingBox();
  if (!box) throw new Error("there is no sheet");
  return ([x, y]) => [box.x + (x * box.width) / 1000, box.y + (y * box.height) / 1000];
}

/** A place of the sheet in the window. */
export const onSheet = async (page: Page, at: Point) => (await inWindow(page))(at);

/** Draws one stroke. */
export async function draw(page: Page, stroke: Point[]) {
  const [first, ...others] = stroke.map(await inWindow(page));
  if (!first) return;
  await page.mouse.move(...first);
  await page.mouse.down();
  for (const point of others) await page.mouse.move(...point);
  await page.mouse.up();
}

/** The outline in strokes of about the same length, closed. */
export function strokes(points: Point[], count: number): Point[][] {
  const closed = [...points, points[0] as Point];
  const length = Math.ceil(closed.length / count);
  return Array.from({ length: count }, (_, i) => {
    const part = closed.slice(i * length, (i + 1) * length + 1);
    return part.filter((_, j) => j % 8 === 0 || j === part.length - 1);
  });
}

/** Frames in which nothing has to move until it stands still: the camera flies without a pause. */
const STILL = 6;

/** Where an element is once it stands still. */
export async function stillBox(element: Locator) {
  await element.evaluate(async (node, still) => {
    let [before, count] = ["", 0];
    while (count < still) {
      await new Promise(requestAnimationFrame);
      const { x, y } = node.getBoundingClientRect();
      count = before === `${x} ${y}` ? count + 1 : 0;
      before = `${x} ${y}`;
    }
  }, STILL);
  const box = await element.boundingBox();
  if (!box) throw new Error("the element is gone");
  return box;
}

/** Opens the page and waits until there is a mesh. */
export async function open(page: Page, address = "/") {
  await page.goto(address);
  await expect(page.locator(".chooser")).toContainText("Cat");
}

/** Waits for an answer to what is drawn now. */
export async function matched(page: Page) {
  await expect(page.locator(".rated:not(.past)")).toBeVisible();
  await expect(page.getByRole("progressbar")).toHaveCount(0);
}
