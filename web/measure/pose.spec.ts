/** Frames per second while a handle of a mesh of 50,000 vertices is dragged. */
import { matched, open } from "../tests/drawing";
import { expect, test } from "../tests/server";

const VERTICES = 50_000;
/** Frames that are counted. */
const FRAMES = 150;

/** An OBJ with more vertices: every side halved, and then as many triangles as are wanted parted at their middle. */
function refined(obj: string, wanted: number): string {
  const rows = (letter: string) => obj.split("\n").filter((line) => line.startsWith(`${letter} `));
  const places = rows("v").map((line) => line.split(/\s+/).slice(1, 4).map(Number));
  let faces = rows("f").map((line) =>
    line
      .split(/\s+/)
      .slice(1, 4)
      .map((corner) => Number.parseInt(corner, 10) - 1),
  );
  const mean = (corners: number[]) =>
    places.push([0, 1, 2].map((i) => corners.reduce((sum, v) => sum + (places[v]?.[i] ?? 0), 0) / corners.length)) - 1;
  const middles = new Map<string, number>();
  const middle = (a = 0, b = 0) => {
    const key = `${Math.min(a, b)} ${Math.max(a, b)}`;
    const known = middles.get(key) ?? mean([a, b]);
    middles.set(key, known);
    return known;
  };
  faces = faces.flatMap(([a = 0, b = 0, c = 0]) => {
    const [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
    return [
      [a, ab, ca],
      [ab, b, bc],
      [ca, bc, c],
      [ab, bc, ca],
    ];
  });
  faces = faces.flatMap(([a = 0, b = 0, c = 0]) => {
    if (places.length >= wanted) return [[a, b, c]];
    const m = mean([a, b, c]);
    return [
      [a, b, m],
      [b, c, m],
      [c, a, m],
    ];
  });
  const lines = (letter: string, numbers: number[][]) => numbers.map((row) => `${letter} ${row.join(" ")}`);
  return [
    ...lines("v", places),
    ...lines(
      "f",
      faces.map((face) => face.map((v) => v + 1)),
    ),
  ].join("\n");
}

test("frames per second while posing", async ({ page }) => {
  await open(page);
  await page.getByRole("button", { name: "Draw it for me" }).click();
  await matched(page);
  const obj = await (await page.request.get("/v1/examples/quadruped/mesh")).text();
  const file = { name: "fine.obj", mimeType: "model/obj", buffer: Buffer.from(refined(obj, VERTICES)) };
  await page.locator("input[aria-label^='Open a mesh']").setInputFiles(file);
  await expect(page.locator(".chooser")).toContainText("fine.obj", { timeout: 300_000 });
  await expect(page.locator(".rated:not(.past)")).toBeVisible({ timeout: 300_000 });
  await expect(page.getByRole("progressbar")).toHaveCount(0, { timeout: 300_000 });
  await page.keyboard.press("h");
  await page.getByRole("button", { name: "Set some for me" }).click();
  await expect(page.getByText("Drag a handle and the mesh follows")).toBeVisible({ timeout: 300_000 });

  const box = await page.getByRole("button", { name: "Point 2;" }).boundingBox();
  if (!box) throw new Error("no handle");
  const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(x, y);
  await page.mouse.down();
  const { times, busy } = await page.evaluate(
    async ([x, y, count]) => {
      const handle = document.querySelectorAll(".handles .base")[1] as SVGElement;
      const frame = () => new Promise<number>(requestAnimationFrame);
      const times: number[] = [];
      const busy: number[] = [];
      for (let i = 0; i <= count; i++) {
        times.push(await frame());
        const start = performance.now();
        const [clientX, clientY] = [x + 40 * Math.sin(i / 12), y + 40 * Math.cos(i / 12) - 40];
        handle.dispatchEvent(new PointerEvent("pointermove", { pointerId: 1, clientX, clientY, bubbles: true }));
        busy.push(performance.now() - start);
      }
      return { times, busy };
    },
    [x, y, FRAMES] as const,
  );
  await page.mouse.up();
  const steps = times.slice(1).map((time, i) => time - (times[i] ?? 0));
  const median = (numbers: number[]) => numbers.toSorted((a, b) => a - b)[numbers.length >> 1] ?? 0;
  const whole = (times.at(-1) ?? 0) - (times[0] ?? 0);
  console.log("\n| frames | per second | median of a frame, ms | of it to blend, ms |\n|---|---|---|---|");
  console.log(
    `| ${FRAMES} | ${((1000 * FRAMES) / whole).toFixed(1)} | ${median(steps).toFixed(1)} | ${median(busy).toFixed(1)} |`,
  );
});
