// Matches an example creature with a generated client: node walk.js SERVER MESH SKETCH
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import createClient from "openapi-fetch";
import type { components, paths } from "./api.js";

type Match = components["schemas"]["MatchDocument"];

const [server, meshFile, sketchFile] = process.argv.slice(2);
const client = createClient<paths>({ baseUrl: server });

const mesh = await client.POST("/v1/meshes", {
  params: { query: { format: "obj", name: "a cat" } },
  headers: { "content-type": "application/octet-stream" },
  body: readFileSync(meshFile, "utf8"),
  bodySerializer: (body) => body,
});
assert(mesh.data, JSON.stringify(mesh.error));
assert(mesh.data.closed && mesh.data.components === 1 && mesh.data.vertices > 4000);

const sketch = await client.POST("/v1/sketches", {
  body: JSON.parse(readFileSync(sketchFile, "utf8")) as components["schemas"]["OutlineRequest"],
});
assert(sketch.data, JSON.stringify(sketch.error));
assert(sketch.data.vertices > 700 && sketch.data.warnings.length === 0);

const asked = await client.POST("/v1/matches", { body: { mesh: mesh.data.id, sketch: sketch.data.id } });
assert(asked.data, JSON.stringify(asked.error));
const path = { id: asked.data.id };

const events = await client.GET("/v1/matches/{id}/events", { params: { path }, parseAs: "text" });
const told = String(events.data).split("\n").filter((line) => line.startsWith("data:"));
const last: Match = JSON.parse(told[told.length - 1].slice("data:".length));
assert.equal(last.status, "succeeded");
assert.equal(last.progress.fraction, 1);

const result = await client.GET("/v1/matches/{id}/result", { params: { path } });
assert(result.data, JSON.stringify(result.error));
const answer: components["schemas"]["MatchResult"] = result.data;
assert.equal(answer.correspondences.length, sketch.data.vertices);
assert.deepEqual([answer.c.rows, answer.c.columns, answer.rating], [20, 20, "high"]);
assert.deepEqual([answer.mesh, answer.sketch, answer.match], [mesh.data.id, sketch.data.id, path.id]);

const picture = await client.GET("/v1/matches/{id}/picture", { params: { path, query: { width: 400 } }, parseAs: "arrayBuffer" });
assert(picture.data, JSON.stringify(picture.error));
const bytes = Buffer.from(picture.data);
assert.deepEqual([bytes.toString("latin1", 1, 4), bytes.readUInt32BE(16)], ["PNG", 400]);

const missing = await client.GET("/v1/matches/{id}", { params: { path: { id: "none" } } });
assert.equal(missing.error?.status, 404);
console.log(`matched ${answer.correspondences.length} points, ${answer.rating}`);
