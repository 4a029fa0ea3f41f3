// Matches a sketch to a mesh and poses the mesh: one end of the drawing is held, the other turned.
//
//     node match_and_pose.mjs http://127.0.0.1:8080 example/quadruped/mesh.obj example/quadruped/sketch.json posed.obj
//
// Needs Node 20 and a server that runs; no packages.
import { readFile, writeFile } from "node:fs/promises";

const [server, meshFile, sketchFile, output] = process.argv.slice(2);

/** What a call answers; an error with the server's own words where it refuses. */
async function call(method, path, { body, type = "application/json", accept = "application/json", prefer } = {}) {
  const headers = { Accept: accept };
  if (body !== undefined) headers["Content-Type"] = type;
  if (prefer) headers.Prefer = prefer;
  const answer = await fetch(server + path, { method, headers, body });
  if (!answer.ok) throw new Error(await answer.text());
  return accept === "application/json" ? answer.json() : answer.text();
}

/** A job that was asked for, once it has ended. */
async function ended(job) {
  while (job.status === "queued" || job.status === "running") {
    await new Promise((resolve) => setTimeout(resolve, 200));
    job = await call("GET", job.links.self);
  }
  if (job.status !== "succeeded") throw new Error(JSON.stringify(job.error));
  return job;
}

const mesh = await call("POST", "/v1/meshes", { body: await readFile(meshFile), type: "application/octet-stream" });
const sketch = await call("POST", "/v1/sketches", { body: await readFile(sketchFile) });
const request = { mesh: mesh.id, sketch: sketch.id };
const match = await ended(
  await call("POST", "/v1/matches", { body: JSON.stringify(request), prefer: "wait=30" }),
);
const result = await call("GET", match.links.result);
console.log(`${result.correspondences.length} points, rated ${result.rating}`);

// The vertices of the sketch farthest to the left and to the right, and the one in the middle between both.
const points = result.correspondences.map(({ point }) => point);
const [left, right] = [points.reduce((a, b) => (b[0] < a[0] ? b : a)), points.reduce((a, b) => (b[0] > a[0] ? b : a))];
const centre = [(left[0] + right[0]) / 2, (left[1] + right[1]) / 2];
const away = ([x, y]) => Math.hypot(x - centre[0], y - centre[1]);
const middle = points.reduce((a, b) => (away(b) < away(a) ? b : a));

const pose = {
  match: match.id,
  handles: [left, middle, right].map((at) => ({ type: "point", at })),
  frames: [[{ type: "stay" }, { type: "stay" }, { type: "rotation", degrees: 20, about: middle }]],
};
const posed = await ended(await call("POST", "/v1/poses", { body: JSON.stringify(pose), prefer: "wait=30" }));
const { frames } = await call("GET", posed.links.result);
console.log(`triangles turned over: ${frames[0].strain.flipped_triangles}`);
await writeFile(output, await call("GET", posed.links.result, { accept: "model/obj" }));
console.log(`the mesh in its pose: ${output}`);
