import { writeFileSync } from "node:fs";
import { matched } from "./drawing";
import { expect, Server, test } from "./server";

const KEY = "sketchmatch_a_key_that_only_this_test_knows";

test("a server with keys is used with one, and says what is wrong without", async ({ browser }) => {
  const server = new Server();
  writeFileSync(server.file("keys"), `${KEY}\n`);
  await server.start("--api-keys", server.file("keys"));
  const page = await browser.newPage({ baseURL: server.url });
  const unsigned: string[] = [];
  page.on("response", (answer) => answer.status() === 401 && unsigned.push(answer.url()));
  await page.goto("/");
  await expect(page.getByRole("alert")).toHaveText("This server asks for a key: enter it at the top.");
  const field = page.getByLabel("Key", { exact: true });
  await field.fill("sketchmatch_some_other_key");
  await page.getByRole("button", { name: "Use" }).click();
  await expect(page.getByRole("alert")).toContainText("This key is unknown here");
  await field.fill(KEY);
  await field.press("Enter");
  await expect(page.locator(".chooser")).toContainText("Cat");
  await expect(field).toHaveCount(0);

  // Nothing is asked without the key: neither the events of a match nor any picture.
  unsigned.length = 0;
  await page.getByRole("button", { name: "Draw it for me" }).click();
  await matched(page);
  const isPainted = (image: HTMLImageElement) => image.naturalWidth > 0;
  const pictures = page.locator(".alternatives img");
  await expect.poll(() => pictures.first().evaluate(isPainted)).toBe(true);
  await page.getByRole("button", { name: "Cat" }).first().click();
  await expect.poll(() => page.locator(".gallery img").first().evaluate(isPainted)).toBe(true);
  await page.keyboard.press("Escape");
  await page.keyboard.press("h");
  await page.getByRole("button", { name: "Set some for me" }).click();
  await expect(page.getByText("Drag a handle and the mesh follows")).toBeVisible();
  expect(unsigned).toEqual([]);

  // What is copied has no key in it, and neither has the address.
  await page.getByText("Look inside").click();
  await page.getByRole("tab", { name: "Request" }).click();
  for (const language of ["curl", "Python", "JavaScript"]) {
    await page.getByRole("button", { name: language }).click();
    await expect(page.locator("pre")).toContainText("SKETCHMATCH_KEY");
    await expect(page.locator("pre")).not.toContainText(KEY);
  }
  // It is kept in this window only.
  const kept = await page.evaluate(() => [JSON.stringify(localStorage), document.cookie, location.href].join());
  expect(kept).not.toContain(KEY);
  await page.close();
  await server.close();
});
