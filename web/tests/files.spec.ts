import type { Page } from "@playwright/test";
import { matched, open } from "./drawing";
import { expect, test } from "./server";

/** The bytes of what the server answers. */
async function fetched(page: Page, path: string, accept: string): Promise<Buffer> {
  return (await page.request.get(path, { headers: { accept } })).body();
}

const drawingInput = "input[aria-label^='Open a drawing']";
const meshInput = "input[aria-label^='Open a mesh']";

test("drawings come as SVG, PNG, JPEG and JSON", async ({ page, complaints }) => {
  await open(page);
  const path = "/v1/examples/quadruped/sketch";
  const png = await fetched(page, path, "image/png");
  const jpeg = await page.evaluate(async (bytes) => {
    const picture = await createImageBitmap(new Blob([new Uint8Array(bytes)], { type: "image/png" }));
    const canvas = Object.assign(document.createElement("canvas"), { width: picture.width, height: picture.height });
    canvas.getContext("2d")?.drawImage(picture, 0, 0);
    const blob = await new Promise<Blob | null>((resolve) => canvas.toBlob(resolve, "image/jpeg"));
    return Array.from(new Uint8Array((await blob?.arrayBuffer()) ?? new ArrayBuffer(0)));
  }, Array.from(png));
  const files = [
    { name: "cat.svg", mimeType: "image/svg+xml", buffer: await fetched(page, path, "image/svg+xml") },
    { name: "cat.png", mimeType: "image/png", buffer: png },
    { name: "cat.jpg", mimeType: "image/jpeg", buffer: Buffer.from(jpeg) },
    { name: "cat.json", mimeType: "application/json", buffer: await fetched(page, path, "application/json") },
  ];
  for (const file of files) {
    await page.locator(drawingInput).setInputFiles(file);
    await matched(page);
    await expect(page.locator(".rating"), file.name).toHaveText(/Good|Fair/);
    await expect(page.locator(".ground")).toBeVisible();
    // What was read lies over the drawing.
    const [read, paper] = [await page.locator(".read").boundingBox(), await page.locator(".paper").boundingBox()];
    expect((read?.width ?? 0) / (paper?.width ?? 1), file.name).toBeGreaterThan(0.5);
    expect(read?.y ?? 0, file.name).toBeGreaterThanOrEqual(paper?.y ?? Infinity);
    expect((read?.y ?? 0) + (read?.height ?? 0), file.name).toBeLessThanOrEqual((paper?.y ?? 0) + (paper?.height ?? 0));
  }
  expect(complaints).toEqual([]);
});

/** A tetrahedron in the formats that are text, and in binary STL and GLB. */
const CORNERS = [
  [0, 0, 0],
  [1, 0, 0],
  [0, 2, 0],
  [0, 0, 3],
];
const FACES = [
  [0, 2, 1],
  [0, 1, 3],
  [1, 2, 3],
  [2, 0, 3],
];

function glb(): Buffer {
  const positions = Buffer.from(new Float32Array(CORNERS.flat()).buffer);
  const indices = Buffer.from(new Uint16Array(FACES.flat()).buffer);
  const json = JSON.stringify({
    asset: { version: "2.0" },
    scenes: [{ nodes: [0] }],
    nodes: [{ mesh: 0 }],
    meshes: [{ primitives: [{ attributes: { POSITION: 0 }, indices: 1 }] }],
    accessors: [
      { bufferView: 0, componentType: 5126, count: 4, type: "VEC3", min: [0, 0, 0], max: [1, 2, 3] },
      { bufferView: 1, componentType: 5123, count: 12, type: "SCALAR" },
    ],
    bufferViews: [
      { buffer: 0, byteOffset: 0, byteLength: positions.length },
      { buffer: 0, byteOffset: positions.length, byteLength: indices.length },
    ],
    buffers: [{ byteLength: positions.length + indices.length }],
  });
  const text = Buffer.from(json.padEnd(Math.ceil(json.length / 4) * 4));
  const binary = Buffer.concat([positions, indices]);
  const chunk = (type: string, body: Buffer) => {
    const head = Buffer.alloc(8);
    head.writeUInt32LE(body.length, 0);
    head.write(type, 4, "latin1");
    return Buffer.concat([head, body]);
  };
  const chunks = Buffer.concat([chunk("JSON", text), chunk("BIN\0", binary)]);
  const head = Buffer.alloc(12);
  head.write("glTF", 0, "latin1");
  head.writeUInt32LE(2, 4);
  head.writeUInt32LE(12 + chunks.length, 8);
  return Buffer.concat([head, chunks]);
}

function stl(): Buffer {
  const file = Buffer.alloc(84 + 50 * FACES.length);
  file.writeUInt32LE(FACES.length, 80);
  FACES.forEach((face, f) => {
    const numbers = face.flatMap((corner) => CORNERS[corner] ?? []);
    numbers.forEach((x, i) => void file.writeFloatLE(x, 84 + 50 * f + 12 + 4 * i));
  });
  return file;
}

const lines = (rows: number[][], before = "") => rows.map((row) => `${before}${row.join(" ")}\n`).join("");

const MESHES: Record<string, Buffer> = {
  "shape.obj": Buffer.from(
    lines(CORNERS, "v ") +
      lines(
        FACES.map((face) => face.map((v) => v + 1)),
        "f ",
      ),
  ),
  "shape.off": Buffer.from(`OFF\n4 4 0\n${lines(CORNERS)}${lines(FACES, "3 ")}`),
  "shape.ply": Buffer.from(
    `ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\nelement face 4\n` +
      `property list uchar int vertex_indices\nend_header\n${lines(CORNERS)}${lines(FACES, "3 ")}`,
  ),
  "shape.stl": stl(),
  "shape.glb": glb(),
};

test("meshes come as OBJ, OFF, PLY, STL and GLB", async ({ page, complaints }) => {
  await open(page);
  for (const [name, buffer] of Object.entries(MESHES)) {
    await page.locator(meshInput).setInputFiles({ name, mimeType: "application/octet-stream", buffer });
    await expect(page.locator(".chooser")).toContainText(name);
    await expect(page.getByRole("application", { name: `${name}, not matched yet` })).toBeVisible();
  }
  await page.getByRole("button", { name: "shape.glb" }).click();
  await page.getByRole("dialog").getByRole("button", { name: "Person" }).click();
  await expect(page.locator(".chooser")).toContainText("Person");
  expect(complaints).toEqual([]);
});

test("a file that is refused says why, and what there was stays", async ({ page }) => {
  await open(page);
  await page.getByRole("button", { name: "Draw it for me" }).click();
  await matched(page);
  const broken = Buffer.from("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n");
  await page.locator(meshInput).setInputFiles({ name: "broken.obj", mimeType: "model/obj", buffer: broken });
  await expect(page.getByRole("alert")).toContainText(/^Line 4, .*out of range/);
  await expect(page.locator(".chooser")).toContainText("Cat");
  await page.getByRole("alert").getByRole("button", { name: "Close" }).click();
  await expect(page.getByRole("alert")).toHaveCount(0);
  const text = { name: "notes.txt", mimeType: "text/plain", buffer: Buffer.from("no drawing") };
  await page.locator(drawingInput).setInputFiles(text);
  await expect(page.getByRole("alert")).toContainText("notes.txt is no drawing");
  const cut = { name: "cut.png", mimeType: "image/png", buffer: Buffer.from("\x89PNG\r\n\x1a\n", "latin1") };
  await page.locator(drawingInput).setInputFiles(cut);
  await expect(page.locator(".status .trouble")).not.toBeEmpty();
});

test("a drawing dropped on the page is opened", async ({ page }) => {
  await open(page);
  const svg = (await fetched(page, "/v1/examples/quadruped/sketch", "image/svg+xml")).toString();
  await page.evaluate((text) => {
    const data = new DataTransfer();
    data.items.add(new File([text], "cat.svg", { type: "image/svg+xml" }));
    document.body.dispatchEvent(new DragEvent("drop", { dataTransfer: data, bubbles: true, cancelable: true }));
  }, svg);
  await matched(page);
});
