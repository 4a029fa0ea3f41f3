/** Calls about meshes and sketches. */
import { call, json, post } from "./call";
import type { Example, Geometry, MeshComponent, MeshDocument, MeshListing, Outline, SketchDocument } from "./types";

export const examples = () => json<Example[]>("/v1/examples");

export const exampleOutline = (example: Example) =>
  json<Outline>(example.links.sketch, { headers: { accept: "application/json" } });

export const exampleMesh = async (example: Example) => (await call(example.links.mesh)).blob();

/** Uploads a mesh; what format it is, its name or its bytes tell. */
export function uploadMesh(file: Blob, name: string): Promise<MeshDocument> {
  const form = new FormData();
  form.append("file", file, name);
  return json<MeshDocument>(`/v1/meshes?name=${encodeURIComponent(name.slice(0, 200))}`, {
    method: "POST",
    body: form,
  });
}

export const mesh = (id: string) => json<MeshDocument>(`/v1/meshes/${id}`);

export const meshes = async (limit: number) => (await json<MeshListing>(`/v1/meshes?limit=${limit}`)).items;

export const meshGeometry = (id: string) => json<Geometry>(`/v1/meshes/${id}/mesh`);

export const components = async (id: string) =>
  (await json<{ components: MeshComponent[] }>(`/v1/meshes/${id}/components`)).components;

export const meshPicture = (id: string, width: number) => `/v1/meshes/${id}/picture?format=png&width=${width}`;

/** Uploads a drawing; `isNew` where the server did not know it before. */
export async function uploadSketch(body: Blob, figure: number, signal: AbortSignal) {
  const answer = await call(`/v1/sketches?figure=${figure}`, post(body, body.type, signal));
  return { document: (await answer.json()) as SketchDocument, isNew: answer.status === 201 };
}

export const sketch = (id: string) => json<SketchDocument>(`/v1/sketches/${id}`);

export const sketchGeometry = (id: string) => json<Geometry>(`/v1/sketches/${id}/mesh`);

export const sketchPicture = (id: string, width: number) => `/v1/sketches/${id}/picture?format=png&width=${width}`;
