import { draw, matched, open, outline, strokes } from "./drawing";
import { expect, test } from "./server";

test("a server that restarts in between is waited for", async ({ page, server }) => {
  await open(page);
  const [first = [], second = []] = strokes(await outline(page, "quadruped"), 2);
  await draw(page, first);
  await server.stop();
  await draw(page, second);
  await expect(page.getByText("The server does not answer.")).toBeVisible();
  await server.start();
  await matched(page);
  await expect(page.getByText("The server does not answer.")).toBeHidden();
});

test("a page opened while the server is busy is matched later", async ({ page }) => {
  let refused = 0;
  await page.route("**/v1/matches", async (route) => {
    if (refused++ > 0) return route.continue();
    const problem = { type: "about:blank", title: "Service Unavailable", status: 503, detail: "the queue is full" };
    await route.fulfill({ status: 503, headers: { "retry-after": "1" }, json: problem });
  });
  await open(page);
  await page.getByRole("button", { name: "Draw it for me" }).click();
  await expect(page.getByText("The queue is full. Trying again")).toBeVisible();
  await matched(page);
});
