import { createHash } from "node:crypto";
import { readFileSync } from "node:fs";
import type { Page } from "@playwright/test";
import { arrays } from "../src/api/safetensors";
import type { PoseResult } from "../src/api/types";
import { affine, movedMesh } from "../src/geometry/handles";
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

/** What the canvas of the mesh shows, as a number that differs with it. */
const picture = async (page: Page) =>
  createHash("sha256")
    .update(await page.locator(".mesh-view canvas").screenshot())
    .digest("hex");

interface Gltf {
  meshes: { primitives: { attributes: { POSITION: number }; targets: { POSITION: number }[] }[] }[];
  accessors: { count: number; bufferView: number; byteOffset?: number }[];
  bufferViews: { byteOffset?: number; byteStride?: number }[];
  animations: unknown[];
}

/** What a GLB holds: x, y, z of every vertex at rest, and how far each frame takes it. */
function poses(file: Buffer) {
  expect(file.toString("latin1", 0, 4)).toBe("glTF");
  const length = file.readUInt32LE(12);
  const { meshes, accessors, bufferViews, animations }: Gltf = JSON.parse(file.toString("utf8", 20, 20 + length));
  const places = (number: number): number[] => {
    const { count, bufferView, byteOffset = 0 } = accessors[number] as Gltf["accessors"][number];
    const { byteOffset: start = 0, byteStride = 12 } = bufferViews[bufferView] as Gltf["bufferViews"][number];
    const first = 20 + length + 8 + start + byteOffset;
    return Array.from({ length: 3 * count }, (_, i) =>
      file.readFloatLE(first + byteStride * Math.floor(i / 3) + 4 * (i % 3)),
    );
  };
  const primitive = meshes[0]?.primitives[0];
  if (!primitive) throw new Error("the file has no mesh");
  const [rest, offsets] = [places(primitive.attributes.POSITION), primitive.targets.map((to) => places(to.POSITION))];
  return { rest, frames: offsets.map((by) => rest.map((x, i) => x + (by[i] ?? Number.NaN))), animations };
}

/** The places of an OBJ. */
const placesOf = (obj: string) =>
  obj
    .split("\n")
    .filter((line) => line.startsWith("v "))
    .flatMap((line) => line.split(/\s+/).slice(1, 4).map(Number));

/** The largest difference between two lists of the same length. */
function off(a: number[], b: number[]): number {
  expect(a.length).toBe(b.length);
  return a.reduce((most, x, i) => Math.max(most, Math.abs(x - (b[i] ?? Number.NaN))), 0);
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

  await page.getByRole("button", { name: "Add a frame after this one" }).click();
  await drag(page, "Point 3;", [-30, -30]);
  const asked = page.waitForRequest((request) => request.url().endsWith("/v1/poses") && request.method() === "POST");
  const glb = poses(await saved(page, "GLB"));
  const request = (await asked).postDataJSON();
  const { frames, handles } = request;
  expect(handles).toHaveLength(6);
  expect(frames).toHaveLength(2);
  expect(frames[0][2]).toEqual({ type: "stay" });
  expect(frames[1][1]).toEqual(frames[0][1]);
  // The file holds the user's mesh and what the server computes of the same request.
  const rest = placesOf(await (await page.request.get("/v1/examples/quadruped/mesh")).text());
  expect(off(glb.rest, rest)).toBeLessThan(1e-5);
  expect(glb.animations).toHaveLength(1);
  const headers = { prefer: "wait=60" };
  const { id } = await (await page.request.post("/v1/poses", { headers, data: request })).json();
  const computed: PoseResult = await (await page.request.get(`/v1/poses/${id}/result`)).json();
  expect(glb.frames).toHaveLength(2);
  glb.frames.forEach((places, i) => {
    expect(off(places, computed.frames[i]?.positions.flat() as number[])).toBeLessThan(1e-5);
    expect(off(places, rest)).toBeGreaterThan(0.02);
  });
  const obj = placesOf((await saved(page, "OBJ")).toString());
  expect(off(obj, glb.frames[1] ?? [])).toBeLessThan(1e-5);
  expect((await saved(page, "PNG")).toString("latin1", 1, 4)).toBe("PNG");
  expect(complaints).toEqual([]);
});

test("what the page blends is the pose that the server computes", async ({ page }) => {
  await withHandles(page);
  await drag(page, "Point 2;", [40, -60]);
  await page.getByRole("button", { name: "Point 3;" }).press("Shift+ArrowLeft");
  const asked = page.waitForRequest((request) => request.url().endsWith("/v1/poses") && request.method() === "POST");
  await page.getByRole("button", { name: "OBJ", exact: true }).click();
  const request = (await asked).postDataJSON();
  const headers = { prefer: "wait=60" };
  const { id } = await (await page.request.post("/v1/poses", { headers, data: request })).json();
  const result: PoseResult = await (await page.request.get(`/v1/poses/${id}/result`)).json();
  const answer = await page.request.get(`/v1/poses/${id}/basis`);
  const { basis, rest, places, axes } = arrays(new Uint8Array(await answer.body()).buffer) as Record<
    string,
    Float32Array
  >;
  if (!basis || !rest || !places || !axes) throw new Error("no basis");
  // Strokes have y down, as the sheet has.
  const maps = request.handles.map(({ at }: { at: [number, number] }, i: number) => {
    const { degrees = 0, by = [0, 0] } = request.frames[0][i];
    return affine({ kind: "point", at }, { degrees, by });
  });
  expect(request.frames[0][2]).toMatchObject({ type: "rotation", degrees: 5 });
  const moved = new Float32Array(rest.length);
  movedMesh({ basis, rest, places, axes }, maps, false, moved);
  const computed = (result.frames[0]?.positions ?? []).flat() as number[];
  expect(off(computed, Array.from(rest))).toBeGreaterThan(0.05);
  expect(off(computed, Array.from(moved))).toBeLessThan(1e-4);
});

test("bones are set by a drag, moved by keys and deleted; frames are played", async ({ page, complaints }) => {
  await open(page);
  await page.getByRole("button", { name: "Draw it for me" }).click();
  await matched(page);
  await page.keyboard.press("h");
  await expect(page.getByText("Click a place of the drawing")).toBeVisible();
  const [from, to] = [await onSheet(page, [400, 480]), await onSheet(page, [560, 480])];
  await page.mouse.move(...from);
  await page.mouse.down();
  await page.mouse.move(...to, { steps: 4 });
  await page.mouse.up();
  await page.mouse.click(...(await onSheet(page, [250, 420])));
  const bone = page.getByRole("button", { name: "Bone 1;" });
  await expect(bone).toBeVisible();
  await expect(page.getByRole("button", { name: "Point 2;" })).toBeVisible();
  await page.getByRole("button", { name: "Move them" }).click();
  await expect(page.getByText("Drag a handle and the mesh follows")).toBeVisible();
  await page.getByRole("button", { name: "Add a frame after this one" }).click();
  const before = await picture(page);
  await bone.press("ArrowUp");
  await bone.press("Shift+ArrowRight");
  await expect.poll(() => picture(page)).not.toBe(before);
  await page.getByRole("button", { name: "Play the frames" }).click();
  await expect(page.getByRole("button", { name: "Pause" })).toBeVisible();
  const places = new Set<string | null>();
  const passed = async () => places.add(await bone.getAttribute("cy")).size;
  await expect.poll(passed).toBeGreaterThan(3);
  await page.getByRole("button", { name: "Pause" }).click();
  await page.getByRole("button", { name: "Point 2;" }).press("Delete");
  await expect(page.getByRole("button", { name: "Point 2;" })).toHaveCount(0);
  // With the pen the drawing and the mesh are at rest again.
  await page.keyboard.press("p");
  await expect(page.getByRole("heading", { name: "Pose the mesh" })).toHaveCount(0);
  expect(complaints).toEqual([]);
});

test("the mesh stands as a drawing shows it", async ({ page, complaints }) => {
  await open(page);
  await page.getByRole("button", { name: "Draw it for me" }).click();
  await matched(page);
  await page.keyboard.press("h");
  const before = await picture(page);
  await page.getByRole("button", { name: "Stand as drawn" }).click();
  await expect(page.getByText("The mesh stands as the drawing shows it.")).toBeVisible();
  await expect.poll(() => picture(page)).not.toBe(before);
  const svg = await (
    await page.request.get("/v1/examples/quadruped/sketch", { headers: { accept: "image/svg+xml" } })
  ).body();
  const file = { name: "other.svg", mimeType: "image/svg+xml", buffer: svg };
  await page.locator("input[aria-label='Take the pose of another drawing']").setInputFiles(file);
  await expect(page.getByText("The mesh stands as other.svg shows it.")).toBeVisible();
  const places = (await saved(page, "OBJ")).toString().split("\n");
  expect(places.filter((line) => line.startsWith("v ")).length).toBeGreaterThan(1000);
  await page.getByRole("button", { name: "Back to the handles" }).click();
  await expect(page.getByRole("button", { name: "Set some for me" })).toBeVisible();
  expect(complaints).toEqual([]);
});
