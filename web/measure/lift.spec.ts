/** From lifting the pen to the colours on the mesh, over 20 strokes of three drawings. */
import type { Page } from "@playwright/test";
import { draw, matched, open, outline } from "../tests/drawing";
import { expect, test } from "../tests/server";

type Point = [number, number];

/** The strokes after the outline, as people add them: eyes, ears, whiskers, a tail, by where they are on the sheet. */
const DETAILS: Record<string, Point[][]> = {
  quadruped: [
    [
      [150, 372],
      [154, 376],
      [158, 372],
    ],
    [
      [120, 400],
      [135, 402],
      [150, 398],
    ],
    [
      [420, 470],
      [450, 480],
      [480, 470],
    ],
    [
      [520, 480],
      [560, 470],
    ],
    [
      [350, 520],
      [380, 540],
    ],
    [
      [600, 520],
      [620, 560],
    ],
  ],
  biped: [
    [
      [490, 130],
      [493, 134],
    ],
    [
      [510, 130],
      [513, 134],
    ],
    [
      [488, 155],
      [500, 160],
      [512, 155],
    ],
    [
      [470, 300],
      [500, 310],
      [530, 300],
    ],
    [
      [480, 420],
      [520, 420],
    ],
    [
      [500, 340],
      [500, 380],
    ],
  ],
};

const DRAWINGS = [
  { name: "cat", mesh: "Cat", creature: "quadruped", bent: 0 },
  { name: "person", mesh: "Person", creature: "biped", bent: 0 },
  { name: "cat, bent", mesh: "Cat", creature: "quadruped", bent: 60 },
];

test("from lifting the pen to the colours", async ({ page }) => {
  const rows: [string, number[]][] = [];
  for (const { name, mesh, creature, bent } of DRAWINGS) {
    await open(page);
    await page
      .getByRole("button", { name: /Cat|Person/ })
      .first()
      .click();
    await page.getByRole("dialog").getByRole("button", { name: mesh }).click();
    await expect(page.locator(".chooser")).toContainText(mesh);
    const clear = page.getByRole("button", { name: "Empty the sheet" });
    if (await clear.isEnabled()) await clear.click();
    const closed = await outline(page, creature);
    const shape = [...closed, closed[0] as Point].map(([x, y]): Point => [x, y + bent * Math.sin(x / 160)]);
    const strokes = [shape.filter((_, i) => i % 4 === 0 || i === shape.length - 1), ...(DETAILS[creature] ?? [])];
    const times: number[] = [];
    // Twenty in all: seven of the first two drawings and six of the last.
    for (const stroke of strokes.slice(0, bent ? 6 : 7)) times.push(await lifted(page, stroke));
    rows.push([name, times]);
  }
  const all = rows.flatMap(([, times]) => times);
  console.log("\n| drawing | strokes | median, ms | slowest, ms |\n|---|---|---|---|");
  for (const [name, times] of [...rows, ["all", all] as const]) {
    console.log(`| ${name} | ${times.length} | ${median(times)} | ${Math.round(Math.max(...times))} |`);
  }
});

/** Draws a stroke; the time from the pen's leaving to the first picture with the new colours, in ms. */
async function lifted(page: Page, stroke: Point[]): Promise<number> {
  await page.evaluate(() => {
    const started = new Promise<number>((resolve) => {
      addEventListener("pointerup", (event) => resolve(event.timeStamp), { once: true, capture: true });
    });
    const coloured = new Promise<number>((resolve) => {
      new PerformanceObserver((list, observer) => {
        const [mark] = list.getEntriesByName("coloured");
        if (!mark) return;
        observer.disconnect();
        resolve(mark.startTime);
      }).observe({ type: "mark" });
    });
    Object.assign(window, { lift: Promise.all([started, coloured]).then(([from, to]) => to - from) });
  });
  await draw(page, stroke);
  const time = await page.evaluate(() => (window as unknown as { lift: Promise<number> }).lift);
  await matched(page);
  return time;
}

function median(numbers: number[]): number {
  const sorted = numbers.toSorted((a, b) => a - b);
  return Math.round(sorted[sorted.length >> 1] ?? 0);
}
