import AxeBuilder from "@axe-core/playwright";
import type { Locator, Page, Request, Route } from "@playwright/test";
import { draw, matched, onSheet, open, outline, stillBox, strokes } from "./drawing";
import { expect, test } from "./server";

/** The share of what is seen of the mesh that is not grey. */
async function colourful(page: Page): Promise<number> {
  const png = await page.locator(".mesh-view canvas").screenshot();
  return page.evaluate(async (bytes) => {
    const picture = await createImageBitmap(new Blob([new Uint8Array(bytes)]));
    const { width, height } = picture;
    const context = Object.assign(document.createElement("canvas"), { width, height }).getContext("2d");
    context?.drawImage(picture, 0, 0);
    const data = context?.getImageData(0, 0, width, height).data ?? [];
    let count = 0;
    for (let i = 0; i < data.length; i += 4) {
      const [r = 0, g = 0, b = 0] = data.slice(i, i + 3);
      if (Math.max(r, g, b) - Math.min(r, g, b) > 40) count++;
    }
    return count / (width * height);
  }, Array.from(png));
}

test("a creature drawn by hand is matched as the pen is lifted", async ({ page, complaints }) => {
  await open(page);
  const [first, second] = strokes(await outline(page, "quadruped"), 2);
  await draw(page, first ?? []);
  await expect(page.locator(".status [role=status]")).not.toBeEmpty();
  await draw(page, second ?? []);
  await matched(page);
  await expect(page.locator(".rating")).toHaveText(/Good|Fair/);
  await expect(page.getByRole("button", { name: "Best answer" })).toHaveAttribute("aria-pressed", "true");
  expect(complaints).toEqual([]);
});

test("an outline that is open says so and is matched once it is closed", async ({ page, complaints }) => {
  await open(page);
  const [first = [], ...others] = strokes(await outline(page, "quadruped"), 4);
  await draw(page, first);
  await expect(page.getByText("The outline is still open")).toBeVisible();
  await expect(page.locator(".mark.open circle")).toHaveCount(2);
  for (const stroke of others) await draw(page, stroke);
  await matched(page);
  await expect(page.getByText("The outline is still open")).toBeHidden();
  expect(complaints).toEqual([]);
});

test("an outline that is open is closed by a click", async ({ page }) => {
  await open(page);
  const creature = await outline(page, "quadruped");
  await draw(
    page,
    creature.filter((_, i) => i % 6 === 0 && i < 0.6 * creature.length),
  );
  await page.getByRole("button", { name: "Close it for me" }).click();
  await expect(page.locator(".ink path")).toHaveCount(2);
  await matched(page);
});

test("undo, redo, the eraser and the mirror change the drawing", async ({ page }) => {
  await open(page);
  const ink = page.locator(".ink path");
  await draw(page, [
    [200, 200],
    [300, 240],
    [400, 200],
  ]);
  await expect(ink).toHaveCount(1);
  await page.keyboard.press("s");
  await draw(page, [
    [200, 500],
    [300, 540],
  ]);
  await expect(ink).toHaveCount(3);
  await page.keyboard.press("Control+z");
  await expect(ink).toHaveCount(1);
  await page.keyboard.press("Control+Shift+z");
  await expect(ink).toHaveCount(3);
  await page.getByRole("button", { name: "Eraser" }).click();
  await draw(page, [
    [300, 180],
    [300, 300],
  ]);
  await expect(ink).toHaveCount(4);
  await page.getByRole("button", { name: "Empty the sheet" }).click();
  await expect(ink).toHaveCount(0);
  await page.getByRole("button", { name: "Undo" }).click();
  await expect(ink).toHaveCount(4);
});

test("a drawing begun anew cancels the match that runs", async ({ page }) => {
  await open(page);
  const matches = async () => (await (await page.request.get("/v1/matches")).json()).items.length;
  const before = await matches();
  // However fast it is matched, the page is not told before the drawing goes on.
  const cancelled = page.waitForRequest(/\/cancel$/);
  const hold = async (route: Route) => {
    await cancelled;
    await route.abort().catch(() => {});
  };
  await page.route("**/events", hold, { times: 1 });
  await page.getByRole("button", { name: "Draw it for me" }).click();
  await page.waitForResponse((answer) => answer.url().endsWith("/v1/matches") && answer.status() === 202);
  await draw(page, [
    [350, 420],
    [360, 430],
  ]);
  await cancelled;
  await matched(page);
  // Nothing is left behind of what a newer match has replaced.
  await expect.poll(matches).toBe(before + 1);
});

test("what a match looks like at first sight is shown as such until the answer is there", async ({ page }) => {
  await open(page);
  const ended = page.waitForResponse((answer) => answer.url().endsWith("/result"));
  await page.getByRole("button", { name: "Draw it for me" }).click();
  const result = await (await ended).json();
  await matched(page);
  // The next match tells of its first sight, and its answer is held back until that was looked at.
  await page.route("**/events", async (route) => {
    const match = await (await page.request.get(route.request().url().replace("/events", ""))).json();
    const told = { ...match, status: "running", progress: { stage: "preview", fraction: 0.3 } };
    await route.fulfill({ contentType: "text/event-stream", body: `event: status\ndata: ${JSON.stringify(told)}\n\n` });
  });
  await page.route("**/result?preview=true", (route) =>
    route.fulfill({ json: { ...result, preview: true, alternatives: [] } }),
  );
  let release = () => {};
  const looked = new Promise<void>((resolve) => {
    release = resolve;
  });
  await page.route("**/result", async (route) => {
    await looked;
    await route.continue();
  });
  await page.getByRole("button", { name: "Set a landmark" }).click();
  await page.mouse.click(...(await onSheet(page, [400, 480])));
  await page.mouse.move(...(await onSheet(page, [400, 480])));
  const mark = await stillBox(page.locator(".mesh-marks .twin"));
  await page.mouse.click(mark.x + mark.width / 2, mark.y + mark.height / 2);
  await expect(page.locator(".rating")).toHaveText("First sight");
  await expect(page.getByRole("button", { name: "Best answer" })).toBeDisabled();
  release();
  await matched(page);
  await expect(page.locator(".rating")).toHaveText(/Good|Fair/);
  await expect(page.getByRole("button", { name: "Best answer" })).toBeEnabled();
});

/** The number of the alternative that the browser keeps for the page. */
const keptAlternative = (page: Page) =>
  page.evaluate(
    () =>
      new Promise((resolve) => {
        const opening = indexedDB.open("keyval-store");
        opening.onsuccess = () => {
          const reading = opening.result.transaction("keyval").objectStore("keyval").get("state-1");
          reading.onsuccess = () => resolve(reading.result?.chosen);
        };
      }),
  );

test("an alternative is one click away", async ({ page }) => {
  await open(page);
  await page.getByRole("button", { name: "Draw it for me" }).click();
  await matched(page);
  await expect.poll(() => colourful(page)).toBeGreaterThan(0.03);
  const mirrored = page.getByRole("button", { name: /Mirrored/ });
  await expect(mirrored.locator("img")).toHaveJSProperty("complete", true);
  await mirrored.click();
  await expect(mirrored).toHaveAttribute("aria-pressed", "true");
  await expect(page.getByRole("application", { name: "alternative 1" })).toBeVisible();
  // It is there again after a reload, once the browser has kept it, and one click goes back.
  await expect.poll(() => keptAlternative(page)).toBe(0);
  await page.reload();
  await expect(mirrored).toHaveAttribute("aria-pressed", "true");
  await page.getByRole("button", { name: "Best answer" }).click();
  await expect(page.getByRole("application", { name: "in the colours of the drawing" })).toBeVisible();
});

test("hovering one side shows the point on the other", async ({ page }) => {
  await open(page);
  await page.getByRole("button", { name: "Draw it for me" }).click();
  await matched(page);
  await page.mouse.move(...(await onSheet(page, [400, 480])));
  await expect(page.locator(".mesh-marks .twin")).toBeVisible();
  const mark = await stillBox(page.locator(".mesh-marks .twin"));
  await page.mouse.move(mark.x + mark.width / 2, mark.y + mark.height / 2);
  await expect(page.locator(".sheet .twin")).toBeVisible();
  const there = await page.locator(".sheet .twin").boundingBox();
  const [x, y] = await onSheet(page, [400, 480]);
  expect(Math.hypot((there?.x ?? 0) + 6 - x, (there?.y ?? 0) + 6 - y)).toBeLessThan(30);
});

test("a landmark is set by two clicks, sent, and deleted", async ({ page }) => {
  await open(page);
  await page.getByRole("button", { name: "Draw it for me" }).click();
  await matched(page);
  await page.getByRole("button", { name: "Set a landmark" }).click();
  await page.mouse.click(...(await onSheet(page, [400, 480])));
  await expect(page.getByText("Now click the same place on the mesh")).toBeVisible();
  await page.mouse.move(...(await onSheet(page, [400, 480])));
  const mark = await stillBox(page.locator(".mesh-marks .twin"));
  const sent = page.waitForRequest((request) => request.url().endsWith("/v1/matches") && request.method() === "POST");
  await page.mouse.click(mark.x + mark.width / 2, mark.y + mark.height / 2);
  const { landmarks } = (await sent).postDataJSON();
  expect(landmarks).toHaveLength(1);
  expect(landmarks[0].sketch[0]).toBeCloseTo(400, -1);
  await expect(page.locator(".landmarks li")).toHaveText(/vertex \d+/);
  await matched(page);
  // Dragged on either side, it is sent as it stands then.
  const dragged = async (pin: Locator, [dx, dy]: [number, number]) => {
    const { x, y, width, height } = await stillBox(pin);
    const isSent = (request: Request) =>
      request.url().endsWith("/v1/matches") && JSON.stringify(request.postDataJSON().landmarks) !== before;
    const asked = page.waitForRequest(isSent);
    await page.mouse.move(x + width / 2, y + height / 2);
    await page.mouse.down();
    await page.mouse.move(x + width / 2 + dx, y + height / 2 + dy, { steps: 4 });
    await page.mouse.up();
    return (await asked).postDataJSON().landmarks;
  };
  let before = JSON.stringify(landmarks);
  const onDrawing = await dragged(page.getByRole("button", { name: "Landmark 1 on the drawing" }), [14, 0]);
  expect(onDrawing[0].sketch[0]).toBeGreaterThan(landmarks[0].sketch[0]);
  await matched(page);
  before = JSON.stringify(onDrawing);
  const onMesh = await dragged(page.getByRole("button", { name: "Landmark 1 on the mesh" }), [24, 0]);
  expect(onMesh[0].mesh).not.toBe(onDrawing[0].mesh);
  await matched(page);
  await page.getByRole("button", { name: "Remove landmark 1" }).click();
  await expect(page.locator(".landmarks li")).toHaveCount(0);
  await matched(page);
});

test("a setting of the method is sent, and the answer shows it", async ({ page, complaints }) => {
  await open(page);
  await page.getByRole("button", { name: "Draw it for me" }).click();
  await matched(page);
  await page.getByText("Look inside").click();
  const sent = page.waitForRequest((request) => request.url().endsWith("/v1/matches") && request.method() === "POST");
  await page.getByRole("button", { name: /Nuclear norm/ }).click();
  expect((await sent).postDataJSON().regulariser).toEqual({ type: "nuclear" });
  await matched(page);
  await page.getByRole("tab", { name: "Objective" }).click();
  await expect(page.getByText(/nuclear: objective/)).toBeVisible();
  await page.getByRole("tab", { name: "Functional map" }).click();
  await page.getByRole("button", { name: /C\(1, 1\)/ }).press("ArrowRight");
  await expect(page.locator(".heat-map output")).toHaveText(/^C\(1, 2\) = -?\d/);
  await page.getByRole("tab", { name: "Regions and eigenfunctions" }).click();
  await page.getByRole("button", { name: "Eigenfunctions" }).click();
  await expect(page.getByText("Eigenfunction 2")).toBeVisible();
  await page.getByRole("tab", { name: "Request" }).click();
  for (const language of ["Python", "JavaScript", "curl"]) {
    await page.getByRole("button", { name: language }).click();
    await expect(page.locator("pre")).toContainText("nuclear");
  }
  expect(complaints).toEqual([]);
});

test("the state is there after a reload and behind a link", async ({ page, context }) => {
  await context.grantPermissions(["clipboard-read", "clipboard-write"]);
  await open(page);
  await page.getByRole("button", { name: "Draw it for me" }).click();
  await matched(page);
  await page.reload();
  await matched(page);
  await expect(page.locator(".ink path")).toHaveCount(1);
  await page.getByRole("button", { name: "Copy link" }).click();
  await expect(page.getByText("Copied")).toBeVisible();
  const link = await page.evaluate(() => navigator.clipboard.readText());
  const other = await (await context.browser())?.newContext();
  const there = await other?.newPage();
  if (!there) throw new Error("no page");
  await there.goto(link);
  await matched(there);
  await expect(there.locator(".ink path")).toHaveCount(1);
  await other?.close();
});

test("everything is done by keys alone", async ({ page }) => {
  await open(page);
  const sheet = page.getByRole("application", { name: "Sheet to draw on" });
  await sheet.focus();
  await sheet.press("ArrowLeft");
  await sheet.press("Space");
  for (let i = 0; i < 10; i++) await sheet.press("ArrowUp");
  await sheet.press("Space");
  await expect(page.locator(".ink path")).toHaveCount(1);
  await page.keyboard.press("Control+z");
  await page.getByRole("button", { name: "Draw it for me" }).focus();
  await page.keyboard.press("Enter");
  await matched(page);
  await page.getByRole("button", { name: /Mirrored/ }).focus();
  await page.keyboard.press("Enter");
  const mesh = page.getByRole("application", { name: "alternative 1" });
  await mesh.focus();
  await mesh.press("ArrowRight");
  await page.keyboard.press("l");
  await sheet.focus();
  for (const key of ["ArrowLeft", "ArrowUp", "Enter"]) await sheet.press(key);
  await mesh.focus();
  // The cross starts in the middle, which may be between the legs: up until it is on the body.
  const isOnBody = async () => {
    await mesh.press("ArrowUp");
    await page.evaluate(() => new Promise(requestAnimationFrame));
    return page.locator(".mesh-marks .twin").count();
  };
  await expect.poll(isOnBody).toBe(1);
  await mesh.press("Enter");
  await expect(page.locator(".landmarks li")).toHaveText(/vertex \d+/);
});

for (const theme of ["light", "dark"] as const) {
  test(`axe finds nothing, ${theme}`, async ({ page }) => {
    await page.emulateMedia({ colorScheme: theme });
    await open(page);
    const empty = await new AxeBuilder({ page }).analyze();
    expect(empty.violations.map(({ id, nodes }) => [id, nodes.map(({ html }) => html)])).toEqual([]);
    await page.getByRole("button", { name: "Draw it for me" }).click();
    await matched(page);
    await page.getByText("Look inside").click();
    await expect(page.getByRole("button", { name: /Nuclear norm/ })).toBeVisible();
    const full = await new AxeBuilder({ page }).analyze();
    expect(full.violations.map(({ id, nodes }) => [id, nodes.map(({ html }) => html)])).toEqual([]);
  });
}

test("it works on a phone", async ({ browser, baseURL }) => {
  const context = await browser.newContext({
    ...(baseURL && { baseURL }),
    viewport: { width: 360, height: 740 },
    hasTouch: true,
    isMobile: true,
  });
  const page = await context.newPage();
  await open(page);
  const isWithin = () => page.evaluate(() => document.documentElement.scrollWidth <= innerWidth);
  expect(await isWithin()).toBe(true);
  await page.getByRole("button", { name: "Draw it for me" }).tap();
  await matched(page);
  await page.getByRole("button", { name: "Pose it" }).tap();
  await expect(page.getByText("Drag a handle and the mesh follows")).toBeVisible();
  await page.getByText("Look inside").tap();
  await expect(page.getByRole("button", { name: /Nuclear norm/ })).toBeVisible();
  for (const tab of await page.getByRole("tab").all()) {
    await tab.tap();
    await expect(tab).toHaveAttribute("aria-selected", "true");
    expect(await isWithin(), `${await tab.textContent()}`).toBe(true);
  }
  await context.close();
});
