import { readFileSync } from "node:fs";
import { writeFile } from "node:fs/promises";
import type { Page } from "@playwright/test";
import { matched, onSheet, open } from "./drawing";
import { expect, test } from "./server";

/** Opens the page with a matched drawing and its handles set. */
async function withHandles(page: Page) {
  await open(page);
  await page.getByRole("button", { name: "Draw it for me" }).click();
  await matched(page);
  await page.getByRole("button", { name: "Pose the mesh by handles" }).click();
  await page.getByRole("button", { name: "Set some for me" }).click();
  await expect(page.getByText("Drag a handle and the mesh follows")).toBeVisible();
}

/** The middle of the base of a handle, in the window. */
async function base(page: Page, name: string): Promise<[number, number]> {
  const box = await page.getByRole("button", { name }).boundingBox();
  if (!box) throw new Error(`no ${name}`);
  return [box.x + box.width / 2, box.y + box.height / 2];
}

async function drag(page: Page, name: string, [dx, dy]: [number, number]) {
  const [x, y] = await base(page, name);
  await page.mouse.move(x, y);
  await page.mouse.down();
  await page.mouse.move(x + dx / 2, y + dy / 2);
  await page.mouse.move(x + dx, y + dy);
  await page.mouse.up();
}

/** The canvas of the mesh as it is seen. */
const picture = async (page: Page) => (await page.locator(".mesh-view canvas").screenshot()).toString("base64");

interface Gltf {
  meshes: { primitives: { attributes: { POSITION: number }; targets?: { POSITION: number }[] }[] }[];
  accessors: { count: number; min?: number[]; max?: number[] }[];
  animations?: unknown[];
}

/** The JSON within a GLB. */
function gltf(file: Buffer): Gltf {
  expect(file.toString("latin1", 0, 4)).toBe("glTF");
  return JSON.parse(file.toString("utf8", 20, 20 + file.readUInt32LE(12)));
}

async function saved(page: Page, format: string): Promise<Buffer> {
  const download = page.waitForEvent("download");
  await page.getByRole("button", { name: format, exact: true }).click();
  const file = await download;
  expect(file.suggestedFilename()).toBe(`Cat posed.${format.toLowerCase()}`);
  return readFileSync(await file.path());
}

test("the mesh follows a handle as it is dragged, and is saved as it stands", async ({ page, complaints }) => {
  await withHandles(page);
  const before = await picture(page);
  const sent: string[] = [];
  page.on("request", (request) => sent.push(request.url()));
  await drag(page, "Point 2;", [40, -60]);
  await expect.poll(() => picture(page)).not.toBe(before);
  // The page blends by itself.
  expect(sent.filter((address) => address.includes("/v1/"))).toEqual([]);

  // What is seen is what the server computes of the same request.
  await page.getByRole("button", { name: "Add a frame after this one" }).click();
  await drag(page, "Point 3;", [-30, -30]);
  const asked = page.waitForRequest((request) => request.url().endsWith("/v1/poses") && request.method() === "POST");
  const glb = gltf(await saved(page, "GLB"));
  const { frames, handles } = (await asked).postDataJSON();
  expect(handles).toHaveLength(6);
  expect(frames).toHaveLength(2);
  expect(frames[0][2]).toEqual({ type: "stay" });
  expect(frames[1][1]).toEqual(frames[0][1]);
  expect(glb.meshes[0]?.primitives[0]?.targets).toHaveLength(2);
  expect(glb.animations).toHaveLength(1);
  const obj = (await saved(page, "OBJ")).toString();
  const places = obj.split("\n").filter((line) => line.startsWith("v "));
  const rest = (await (await page.request.get("/v1/examples/quadruped/mesh")).text()).split("\n");
  expect(places).toHaveLength(rest.filter((line) => line.startsWith("v ")).length);
  expect((await saved(page, "PNG")).toString("latin1", 1, 4)).toBe("PNG");
  expect(complaints).toEqual([]);
});
