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

/** What is waited for between the pen lifted and the first colours, in this order; the last is the picture drawn. */
const STEPS = ["sent", "read", "queued", "matched", "fetched", "coloured"] as const;

/** Of one stroke: when each step was over, and when the answer itself was seen, in ms after the pen's leaving. */
type Times = Record<(typeof STEPS)[number] | "answered", number>;

test("from lifting the pen to the colours", async ({ page }) => {
  const rows: [string, Times[]][] = [];
  for (const { name, mesh, creature, bent } of DRAWINGS) {
    // The page comes back as it was left, with the mesh of before.
    if (page.url() === "about:blank") await open(page);
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
    const times: Times[] = [];
    // Twenty in all: seven of the first two drawings and six of the last.
    for (const stroke of strokes.slice(0, bent ? 6 : 7)) times.push(await lifted(page, stroke));
    rows.push([name, times]);
  }
  const all = rows.flatMap(([, times]) => times);
  const table = [...rows, ["all", all] as const];
  console.log("\n| drawing | strokes | first colours: median, ms | slowest, ms | answer: median, ms | slowest, ms |");
  console.log("|---|---|---|---|---|---|");
  for (const [name, times] of table) {
    const [first, answer] = [times.map(({ coloured }) => coloured), times.map(({ answered }) => answered)];
    console.log(
      `| ${name} | ${times.length} | ${median(first)} | ${most(first)} | ${median(answer)} | ${most(answer)} |`,
    );
  }
  console.log("\n| from the pen lifted until | median, ms | by itself, ms |\n|---|---|---|");
  STEPS.forEach((step, i) => {
    const before = STEPS[i - 1];
    const alone = all.map((times) => times[step] - (before ? times[before] : 0));
    console.log(`| ${step} | ${median(all.map((times) => times[step]))} | ${median(alone)} |`);
  });
});

/** Draws a stroke; when each step was over. */
async function lifted(page: Page, stroke: Point[]): Promise<Times> {
  await page.evaluate(() => {
    performance.clearMarks();
    performance.clearResourceTimings();
    addEventListener("pointerup", ({ timeStamp }) => performance.mark("lifted", { startTime: timeStamp }), {
      once: true,
      capture: true,
    });
  });
  await draw(page, stroke);
  await matched(page);
  const coloured = () => page.evaluate(() => performance.getEntriesByName("coloured").length);
  await expect.poll(coloured).toBeGreaterThan(0);
  return page.evaluate(() => {
    const start = performance.getEntriesByName("lifted")[0]?.startTime ?? 0;
    const calls = performance.getEntriesByType("resource") as PerformanceResourceTiming[];
    const call = (pattern: RegExp) => calls.find(({ name }) => pattern.test(name));
    const [sketch, match, result] = [call(/sketches\?/), call(/matches$/), call(/result/)];
    const colours = performance.getEntriesByName("coloured").map(({ startTime }) => startTime - start);
    const after = (time: number | undefined) => (time ?? start) - start;
    return {
      sent: after(sketch?.startTime),
      read: after(sketch?.responseEnd),
      queued: after(match?.responseEnd),
      matched: after(result?.startTime),
      fetched: after(result?.responseEnd),
      coloured: colours[0] ?? 0,
      answered: colours.at(-1) ?? 0,
    };
  });
}

function median(numbers: number[]): number {
  const sorted = numbers.toSorted((a, b) => a - b);
  return Math.round(sorted[sorted.length >> 1] ?? 0);
}

const most = (numbers: number[]) => Math.round(Math.max(...numbers));
