/** Eigenvalues and eigenfunctions of a shape. */
import { call } from "./call";

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

/** The arrays of a file in the format safetensors: the length of a JSON header, the header, the numbers. */
function parsed(file: ArrayBuffer): Spectrum {
  const length = Number(new DataView(file).getBigUint64(0, true));
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(file, 8, length)));
  const array = (name: string) => {
    const [start, end] = header[name].data_offsets as [number, number];
    return new Float64Array(file.slice(8 + length + start, 8 + length + end));
  };
  const eigenvalues = array("eigenvalues");
  return { eigenvalues, eigenfunctions: array("eigenfunctions"), k: eigenvalues.length };
}
