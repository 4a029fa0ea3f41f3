/** The mesh that is matched to. */
import { signal } from "@preact/signals";
import * as api from "../api/shapes";
import { words } from "../api/trouble";
import type { Example, MeshDocument, Outline } from "../api/types";
import { type Surface, surfaceOf } from "../geometry/surface";
import { forgetCorrections } from "./corrections";

export interface Mesh {
  document: MeshDocument;
  surface: Surface;
  /** A drawing of it, where it is an example. */
  outline: Outline | null;
}

export const mesh = signal<Mesh | null>(null);
export const examples = signal<Example[]>([]);
/** What is being fetched, or why it was not had. */
export const meshState = signal<{ loading: string } | { refused: string } | null>(null);

/** The last mesh that was asked for: an earlier one that arrives later is not shown. */
let asked = 0;

async function load(what: string, get: () => Promise<{ document: MeshDocument; outline: Outline | null }>) {
  const turn = ++asked;
  meshState.value = { loading: what };
  try {
    const { document, outline } = await get();
    const surface = surfaceOf(await api.meshGeometry(document.id));
    if (turn !== asked) return;
    if (mesh.value && mesh.value.document.id !== document.id) forgetCorrections();
    mesh.value = { document, surface, outline };
    meshState.value = null;
  } catch (error) {
    if (turn === asked) meshState.value = { refused: words(error) };
    throw error;
  }
}

/** Takes a mesh out of a file. */
export const takeFile = (file: File) =>
  load(file.name, async () => ({ document: await api.uploadMesh(file, file.name), outline: null })).catch(() => {});

export const takeExample = (example: Example) =>
  load(example.name, async () => {
    const [file, outline] = await Promise.all([api.exampleMesh(example), api.exampleOutline(example)]);
    return { document: await api.uploadMesh(file, `${example.name}.obj`), outline };
  });

/** Takes a mesh that the server has. */
export const takeStored = (id: string, name: string) =>
  load(name, async () => {
    const document = await api.mesh(id);
    const example = examples.value.find(({ name }) => document.name === `${name}.obj`);
    return { document, outline: example ? await api.exampleOutline(example) : null };
  });

export const dismiss = () => {
  meshState.value = null;
};
