/** Calls about poses. */
import { call, json, post } from "./call";
import { failure, follow } from "./jobs";
import { arrays } from "./safetensors";
import type { Pose, PoseRequest, PoseResult } from "./types";

/** A pose as a function of where its handles are taken; docs/service.md has the formula. */
export interface Basis {
  /** By rows: vertices of the file × 3 for each handle. */
  basis: Float32Array;
  /** x, y, z of every vertex at rest. */
  rest: Float32Array;
  /** x and y of every vertex in the plane of the drawing. */
  places: Float32Array;
  /** How a vertex moves in space by a unit along x, and by one along y. */
  axes: Float32Array;
}

/** What is made of a pose while the server has it: it is deleted afterwards. */
export async function during<T>(
  request: PoseRequest,
  signal: AbortSignal,
  use: (pose: Pose) => Promise<T>,
): Promise<T> {
  const pose = await posed(request, signal);
  try {
    return await use(pose);
  } finally {
    void call(`/v1/poses/${pose.id}`, { method: "DELETE" }).catch(() => {});
  }
}

/** A pose, asked for and waited for; where `signal` fires it is cancelled. */
async function posed(request: PoseRequest, signal: AbortSignal): Promise<Pose> {
  const started = await json<Pose>("/v1/poses", post(JSON.stringify(request), "application/json"));
  const giveUp = () => void call(`/v1/poses/${started.id}/cancel`, { method: "POST" }).catch(() => {});
  if (signal.aborted) giveUp();
  signal.throwIfAborted();
  signal.addEventListener("abort", giveUp, { once: true });
  const ended = await follow(started, () => {}, signal);
  signal.removeEventListener("abort", giveUp);
  if (ended.status !== "succeeded") throw failure(ended);
  return ended;
}

export const result = (id: string, signal: AbortSignal) => json<PoseResult>(`/v1/poses/${id}/result`, { signal });

export async function basis(id: string, signal: AbortSignal): Promise<Basis> {
  const answer = await call(`/v1/poses/${id}/basis`, { headers: { accept: "application/vnd.safetensors" }, signal });
  const { basis, rest, places, axes } = arrays(await answer.arrayBuffer()) as Record<string, Float32Array>;
  if (!basis || !rest || !places || !axes) throw new Error("the basis lacks an array");
  return { basis, rest, places, axes };
}

/** What a pose is saved as. */
export type Format = "glb" | "obj" | "png";

/** The file of a pose: GLB holds all frames, the others the one of this number. */
export async function file(id: string, format: Format, frame: number): Promise<Blob> {
  if (format === "png") return (await call(`/v1/poses/${id}/picture?frame=${frame}`)).blob();
  const [query, accept] = format === "glb" ? ["", "model/gltf-binary"] : [`?frame=${frame}`, "model/obj"];
  return (await call(`/v1/poses/${id}/result${query}`, { headers: { accept } })).blob();
}
