/** Eigenvalues and eigenfunctions of a shape. */
import { call } from "./call";
import { arrays } from "./safetensors";

export interface Spectrum {
  eigenvalues: Float64Array;
  /** By rows: vertices × k; not a number outside the largest component. */
  eigenfunctions: Float64Array;
  k: number;
}

/** The first `k` eigenpairs of a shape, waited for while they are computed. */
export async function spectrum(kind: "meshes" | "sketches", id: string, k: number, signal: AbortSignal) {
  const options = { headers: { accept: "application/vnd.safetensors" }, signal };
  for (;;) {
    const answer = await call(`/v1/${kind}/${id}/spectrum?k=${k}`, options);
    if (answer.status === 200) return parsed(await answer.arrayBuffer());
    const seconds = Number.parseInt(answer.headers.get("retry-after") ?? "1", 10) || 1;
    await new Promise((resolve) => setTimeout(resolve, 1000 * seconds));
    signal.throwIfAborted();
  }
}

function parsed(file: ArrayBuffer): Spectrum {
  const { eigenvalues, eigenfunctions } = arrays(file) as Record<string, Float64Array>;
  if (!eigenvalues || !eigenfunctions) throw new Error("the spectrum has no eigenpairs");
  return { eigenvalues, eigenfunctions, k: eigenvalues.length };
}
