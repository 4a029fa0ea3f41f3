/** Regions and eigenfunctions, shown in colours on both sides. */
import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { type Spectrum, spectrum } from "../api/spectra";
import { words } from "../api/trouble";
import { coloured } from "../state/colouring";
import { answer } from "../state/live";

/** Eigenpairs that are fetched where the map has fewer: the shortest length in which the server keeps them. */
const PAIRS = 20;

export function Functions() {
  const result = answer.value?.result;
  const spectra = useSignal<[Spectrum, Spectrum] | null>(null);
  const number = useSignal(2);
  const trouble = useSignal("");
  const [sketch, mesh] = [result?.sketch, result?.mesh];
  const count = Math.max(
    PAIRS,
    result?.intermediate.sketch_eigenvalues.length ?? 0,
    result?.intermediate.mesh_eigenvalues.length ?? 0,
  );

  useEffect(() => {
    if (!sketch || !mesh) return;
    const stop = new AbortController();
    spectra.value = null;
    Promise.all([spectrum("sketches", sketch, count, stop.signal), spectrum("meshes", mesh, count, stop.signal)]).then(
      (found) => {
        spectra.value = found;
      },
      (error) => {
        if (!stop.signal.aborted) trouble.value = words(error);
      },
    );
    return () => stop.abort();
  }, [sketch, mesh, count]);

  // The colours go back to those of the places with this tab.
  useEffect(
    () => () => {
      coloured.value = { by: "places" };
    },
    [],
  );

  if (!result) return <p class="hint">There is no answer yet.</p>;
  const show = (i: number) => {
    number.value = i;
    if (!spectra.value) return;
    const [of, on] = spectra.value.map((one) => column(one, i - 1));
    if (of && on) coloured.value = { by: "values", sketch: of, mesh: on };
  };
  const now = coloured.value.by;
  return (
    <>
      <div class="group" role="group" aria-label="Colours of both sides">
        <button
          type="button"
          aria-pressed={now === "places"}
          onClick={() => {
            coloured.value = { by: "places" };
          }}
        >
          Places
        </button>
        <button
          type="button"
          aria-pressed={now === "regions"}
          onClick={() => {
            coloured.value = { by: "regions" };
          }}
        >
          Regions
        </button>
        <button
          type="button"
          aria-pressed={now === "values"}
          disabled={!spectra.value}
          onClick={() => show(number.value)}
        >
          Eigenfunctions
        </button>
      </div>
      {trouble.value && <p class="trouble">{trouble.value}</p>}
      {now === "regions" && <p class="hint">{pairs(result.intermediate.regions.pairs.length)}</p>}
      {spectra.value && (
        <label class="field">
          <span>Eigenfunction {number.value}</span>
          <input
            type="range"
            min={1}
            max={count}
            value={number.value}
            onInput={(event) => show(event.currentTarget.valueAsNumber)}
          />
        </label>
      )}
      <Eigenvalues
        sketch={result.intermediate.sketch_eigenvalues}
        mesh={result.intermediate.mesh_eigenvalues}
        scale={result.intermediate.spectral_scale}
        number={number.value}
        show={show}
      />
    </>
  );
}

const pairs = (count: number) => `${count} pairs of regions correspond; equal colours are one pair.`;

/** The values of one eigenfunction. */
function column({ eigenfunctions, k }: Spectrum, i: number): Float64Array {
  return Float64Array.from({ length: eigenfunctions.length / k }, (_, vertex) => eigenfunctions[vertex * k + i]);
}

interface TableProps {
  sketch: number[];
  mesh: number[];
  scale: number;
  number: number;
  show: (number: number) => void;
}

function Eigenvalues({ sketch, mesh, scale, number, show }: TableProps) {
  const rows = Array.from({ length: Math.max(sketch.length, mesh.length) }, (_, i) => i);
  return (
    <div class="scrolled">
      <table>
        <caption>Eigenvalues at area 1; spectral scale {scale.toPrecision(5)}</caption>
        <thead>
          <tr>
            <th scope="col">number</th>
            <th scope="col">sketch</th>
            <th scope="col">mesh</th>
          </tr>
        </thead>
        <tbody>
          {rows.map((i) => (
            <tr key={i} class={i + 1 === number ? "now" : ""}>
              <th scope="row">
                <button type="button" class="quiet" onClick={() => show(i + 1)}>
                  {i + 1}
                </button>
              </th>
              <td>{sketch[i]?.toFixed(3)}</td>
              <td>{mesh[i]?.toFixed(3)}</td>
            </tr>
          ))}
        </tbody>
      </table>
    </div>
  );
}
