/** Every setting of the method: presets, the regulariser with its formula, and all else a request may say. */
import { useSignal } from "@preact/signals";
import { useEffect } from "preact/hooks";
import { json } from "../api/call";
import { words } from "../api/trouble";
import type { Parameter, Regulariser } from "../api/types";
import { settings } from "../state/corrections";
import { answer } from "../state/live";
import { FieldInput, member, type Value, withMember } from "./Fields";
import { Formula } from "./Formula";
import { type Field, requestFields } from "./schema";

/** What is said elsewhere on the page. */
const ELSEWHERE = new Set(["mesh", "sketch", "landmarks", "up", "part", "components", "regulariser", "preset"]);

const set = (name: string, value: Value) => {
  settings.value = withMember(settings.value, name, value) ?? {};
};

export function Settings() {
  const fields = useSignal<Record<string, Field>>({});
  const regularisers = useSignal<Regulariser[]>([]);
  const trouble = useSignal("");
  useEffect(() => {
    Promise.all([requestFields(), json<Regulariser[]>("/v1/regularisers")]).then(
      ([found, list]) => {
        fields.value = found;
        regularisers.value = list;
      },
      (error) => {
        trouble.value = words(error);
      },
    );
  }, []);
  if (trouble.value) return <p class="trouble">{trouble.value}</p>;
  const used = answer.value?.result.request;
  return (
    <div class="settings">
      <Presets />
      {regularisers.value.length > 0 && <RegulariserForm all={regularisers.value} />}
      {Object.entries(fields.value)
        .filter(([name]) => !ELSEWHERE.has(name))
        .map(([name, field]) => (
          <FieldInput
            key={name}
            name={name}
            field={field}
            value={member(settings.value, name)}
            used={member(used, name)}
            set={(value) => set(name, value)}
          />
        ))}
    </div>
  );
}

const PRESETS = {
  automatic: "Finds the view the drawing is seen from, lays the drawing on it, and answers with those points.",
  thesis: "The method of the thesis: intrinsic, without a view; k = 20, CoSaMP weights, points by indicators.",
} as const;

function Presets() {
  const now = settings.value.preset ?? "automatic";
  return (
    <fieldset>
      <legend>preset</legend>
      <div class="presets">
        {Object.entries(PRESETS).map(([name, meaning]) => (
          <button
            key={name}
            type="button"
            aria-pressed={now === name}
            onClick={() => {
              // What was said beside the other preset is left behind with it.
              settings.value = name === "automatic" ? {} : { preset: "thesis" };
            }}
          >
            <strong>{name}</strong>
            <small class="hint">{meaning}</small>
          </button>
        ))}
      </div>
    </fieldset>
  );
}

function RegulariserForm({ all }: { all: Regulariser[] }) {
  const said = settings.value.regulariser;
  const used = answer.value?.result.request.regulariser;
  const type = said?.type ?? used?.type ?? "l1";
  const shown = all.find((regulariser) => regulariser.type === type);
  return (
    <fieldset>
      <legend>regulariser</legend>
      <div class="presets">
        {all.map((regulariser) => (
          <button
            key={regulariser.type}
            type="button"
            aria-pressed={regulariser.type === type}
            onClick={() => set("regulariser", { type: regulariser.type })}
          >
            <strong>{regulariser.title}</strong>
            <Formula {...regulariser.formula} />
            {regulariser.equation && <small class="hint">equation {regulariser.equation}</small>}
          </button>
        ))}
      </div>
      {shown && <p class="hint">Solved by {shown.solver}.</p>}
      <div class="fields">
        {shown?.parameters.map((parameter) => (
          <FieldInput
            key={parameter.name}
            name={parameter.name}
            field={fieldOf(parameter)}
            value={member(said, parameter.name)}
            used={used?.type === type ? member(used, parameter.name) : parameter.default}
            set={(value) => set("regulariser", withMember({ ...said, type }, parameter.name, value))}
          />
        ))}
      </div>
    </fieldset>
  );
}

function fieldOf(parameter: Parameter): Field {
  const { description } = parameter;
  if (parameter.type === "string") return { kind: "choice", words: parameter.enum, description };
  const { minimum, maximum, type } = parameter;
  return { kind: "number", isInteger: type === "integer", minimum, maximum, default: parameter.default, description };
}
