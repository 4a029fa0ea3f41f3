import AxeBuilder from "@axe-core/playwright";
import type { Page } from "@playwright/test";
import type { Match, Result } from "../src/api/types";
import { matched, open } from "./drawing";
import { expect, test } from "./server";

/** Opens the page with a matched drawing and looks inside; the match that is shown. */
async function inside(page: Page): Promise<Match> {
  await open(page);
  const answered = page.waitForResponse((answer) => answer.url().endsWith("/result"));
  await page.getByRole("button", { name: "Draw it for me" }).click();
  const id = (await answered).url().split("/").at(-2);
  await matched(page);
  await page.getByText("Look inside").click();
  return (await page.request.get(`/v1/matches/${id}`)).json();
}

test("the answer is judged by what a file says is true", async ({ page, complaints }) => {
  const match = await inside(page);
  const result: Result = await (await page.request.get(match.links.result)).json();
  const { vertices } = await (await page.request.get(`/v1/sketches/${result.sketch}/mesh`)).json();
  const said = result.correspondences.filter((_, x) => x % 20 === 0);
  const truth = {
    points: said.map(({ sketch_vertex }) => vertices[sketch_vertex].slice(0, 2)),
    variants: { drawn: said.map(({ mesh_vertex }) => mesh_vertex) },
    side: false,
  };
  await page.getByRole("tab", { name: "Evaluation" }).click();
  const open = (name: string, text: string) =>
    page
      .locator("input[aria-label='Open what is true, as JSON']")
      .setInputFiles({ name, mimeType: "application/json", buffer: Buffer.from(text) });
  await open("truth.json", JSON.stringify(truth));
  // What the answer itself says is judged to be right.
  const pointwise = page.getByRole("row", { name: /each point by itself/ });
  await expect(pointwise).toContainText("0.00");
  await expect(page.locator(".curve .line")).toHaveCount(1);
  // An alternative is judged as it is shown: the mirrored one has the legs of the other side.
  const before = await pointwise.textContent();
  await page.getByRole("button", { name: /Mirrored/ }).click();
  await expect.poll(() => pointwise.textContent()).not.toBe(before);
  // Regions by labels, what the server refuses, and what is no JSON.
  const { vertices: count } = await (await page.request.get(`/v1/meshes/${result.mesh}`)).json();
  const labels = { sketch: vertices.map(() => 0), mesh: Array(count).fill(0) };
  await open("labels.json", JSON.stringify({ labels }));
  await expect(page.getByText(`${vertices.length} of ${vertices.length} points are in the right region`)).toBeVisible();
  await open("short.json", JSON.stringify({ labels: { ...labels, mesh: [0] } }));
  await expect(page.locator("#tab-panel .trouble")).not.toBeEmpty();
  await open("notes.txt", "no JSON");
  await expect(page.locator("#tab-panel .trouble")).toHaveText("notes.txt is no JSON.");
  expect(complaints).toEqual([]);
});

test("both presets are shown side by side with what they differ in", async ({ page, complaints }) => {
  await inside(page);
  await page.getByRole("tab", { name: "Presets side by side" }).click();
  await page.getByRole("button", { name: "Match by both" }).click();
  await expect(page.locator(".side-by-side figure")).toHaveCount(2);
  await expect(page.getByRole("row", { name: /^conversion, method / })).toBeVisible();
  expect(complaints).toEqual([]);
});

for (const theme of ["light", "dark"] as const) {
  test(`axe finds nothing on any tab, nor while the mesh is posed, ${theme}`, async ({ page }) => {
    await page.emulateMedia({ colorScheme: theme });
    await inside(page);
    const faults = async () => {
      const { violations } = await new AxeBuilder({ page }).analyze();
      return violations.map(({ id, nodes }) => [id, nodes.map(({ html }) => html)]);
    };
    await page.getByRole("button", { name: "Pose the mesh by handles" }).click();
    await page.getByRole("button", { name: "Set some for me" }).click();
    await expect(page.getByText("Drag a handle and the mesh follows")).toBeVisible();
    for (const tab of await page.getByRole("tab").all()) {
      await tab.click();
      await expect(tab).toHaveAttribute("aria-selected", "true");
      // No part of a tab is still being fetched.
      await expect(page.locator("#tab-panel > *").first()).toBeVisible();
      expect(await faults(), `${await tab.textContent()}`).toEqual([]);
    }
    await page.keyboard.press("l");
    await page.getByRole("button", { name: "Cat" }).first().click();
    expect(await faults(), "choosing a mesh").toEqual([]);
    await page.keyboard.press("Escape");
    await page.getByRole("button", { name: /See what was understood/ }).click();
    expect(await faults(), "what was understood").toEqual([]);
  });
}
