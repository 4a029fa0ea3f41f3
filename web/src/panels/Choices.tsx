/** What may be said where the answer is wrong: which way is up, which part and which components are matched. */
import { useSignal, useSignalEffect } from "@preact/signals";
import * as api from "../api/shapes";
import type { MeshComponent, Ups } from "../api/types";
import { components, type Part, part, up } from "../state/corrections";
import { answer } from "../state/live";
import { type Mesh, mesh } from "../state/mesh";

export function Choices() {
  if (!answer.value || !mesh.value) return null;
  return (
    <section class="panel" aria-labelledby="choices">
      <h2 id="choices">Say what you know</h2>
      <div class="fields">
        <Up of="sketch" label="Top of the drawing" directions={SHEET} />
        <Up of="mesh" label="Top of the mesh" directions={AXES} />
        <label class="field">
          <span>The drawing shows</span>
          <select
            value={part.value ?? "auto"}
            onChange={({ currentTarget: { value } }) => {
              part.value = value === "auto" ? null : (value as Part);
            }}
          >
            <option value="auto">whatever fits</option>
            <option value="whole">the whole body</option>
            <option value="side">the side in front only</option>
          </select>
        </label>
      </div>
      {mesh.value.document.components > 1 && <Components of={mesh.value} />}
    </section>
  );
}

/** Directions of the sheet, where y is down. */
const SHEET = { "up on the sheet": [0, -1], right: [1, 0], "down on the sheet": [0, 1], left: [-1, 0] };
const AXES = { x: [1, 0, 0], "−x": [-1, 0, 0], y: [0, 1, 0], "−y": [0, -1, 0], z: [0, 0, 1], "−z": [0, 0, -1] };

interface UpProps {
  of: "sketch" | "mesh";
  label: string;
  directions: Record<string, number[]>;
}

function Up({ of, label, directions }: UpProps) {
  const said = up.value[of];
  const name = Object.keys(directions).find((name) => String(directions[name]) === String(said));
  const set = (value: string) => {
    const { [of]: _, ...other } = up.value;
    const direction = value === "none" ? "none" : directions[value];
    up.value = direction ? ({ ...other, [of]: direction } as Ups) : other;
  };
  return (
    <label class="field">
      <span>{label}</span>
      <select value={said === "none" ? "none" : (name ?? "")} onChange={(event) => set(event.currentTarget.value)}>
        <option value="">{of === "sketch" ? "as drawn" : `as understood${understood()}`}</option>
        {Object.keys(directions).map((name) => (
          <option key={name} value={name}>
            {name}
          </option>
        ))}
        <option value="none">not known</option>
      </select>
    </label>
  );
}

/** The axis that the server takes for up on the mesh. */
function understood(): string {
  const direction = mesh.value?.document.up?.direction;
  const name = Object.entries(AXES).find(([, axis]) => String(axis) === String(direction))?.[0];
  return name ? `: ${name}` : "";
}

/** Components that are offered: those of most area. */
const SHOWN = 12;

function Components({ of }: { of: Mesh }) {
  const all = useSignal<MeshComponent[]>([]);
  useSignalEffect(() => {
    const id = mesh.value?.document.id;
    if (!id) return;
    api.components(id).then(
      (found) => {
        if (mesh.value?.document.id === id) all.value = found;
      },
      () => {},
    );
  });
  const whole = all.value.reduce((sum, { area }) => sum + area, 0);
  const largest = all.value.toSorted((a, b) => b.area - a.area).slice(0, SHOWN);
  const taken = components.value ?? answer.value?.result.request.components ?? [];
  const toggle = (number: number) => {
    const next = taken.includes(number) ? taken.filter((other) => other !== number) : [...taken, number];
    components.value = next.length > 0 ? next.sort((a, b) => a - b) : null;
  };
  return (
    <fieldset class="components">
      <legend>Parts of the mesh that are matched</legend>
      {largest.map(({ component, area, triangles }) => (
        <label key={component}>
          <input type="checkbox" checked={taken.includes(component)} onChange={() => toggle(component)} />
          Part {component}: {Math.round((100 * area) / whole)} % of the area, {triangles.toLocaleString()} triangles
        </label>
      ))}
      {of.document.components > SHOWN && (
        <p class="hint">
          The {SHOWN} largest of {of.document.components}.
        </p>
      )}
      {components.value && (
        <button
          type="button"
          onClick={() => {
            components.value = null;
          }}
        >
          Let it choose
        </button>
      )}
    </fieldset>
  );
}
