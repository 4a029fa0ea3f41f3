/** A form made from a schema: what is left empty is what the preset says. */
import { useId } from "preact/hooks";
import type { Field } from "./schema";

export type Value = unknown;
type Group = Record<string, Value>;

interface Props {
  name: string;
  field: Field;
  /** What is said; undefined where nothing is. */
  value: Value;
  /** What is used where nothing is said, as far as it is known. */
  used: Value;
  set: (value: Value) => void;
}

export function FieldInput(props: Props) {
  switch (props.field.kind) {
    case "choice":
      return <Choice {...props} field={props.field} />;
    case "number":
      return <NumberInput {...props} field={props.field} />;
    case "numbers":
      return <Numbers {...props} field={props.field} />;
    case "fields":
      return <Fields {...props} fields={props.field.fields} />;
    case "variants":
      return <Variants {...props} field={props.field} />;
    case "json":
      return <JsonInput {...props} />;
  }
}

type Of<K extends Field["kind"]> = Props & { field: Extract<Field, { kind: K }> };

/** A name of the interface as words. */
const worded = (name: string) => NAMES[name] ?? name.replaceAll("_", " ");

const NAMES: Record<string, string> = { hks: "heat kernel", wks: "wave kernel" };

const byPreset = (used: Value) => (used === undefined ? "by the preset" : `${used}, by the preset`);

function Choice({ name, field, value, used, set }: Of<"choice">) {
  return (
    <label class="field">
      <span>{worded(name)}</span>
      <select value={String(value ?? "")} onChange={(event) => set(event.currentTarget.value || undefined)}>
        <option value="">{byPreset(used)}</option>
        {field.words.map((word) => (
          <option key={word}>{word}</option>
        ))}
      </select>
      <Help>{field.description}</Help>
    </label>
  );
}

function NumberInput({ name, field, value, used, set }: Of<"number">) {
  const { minimum, maximum, isInteger } = field;
  return (
    <label class="field">
      <span>{worded(name)}</span>
      <input
        type="number"
        inputMode="decimal"
        step={isInteger ? 1 : "any"}
        min={minimum}
        max={maximum}
        value={value === undefined ? "" : String(value)}
        placeholder={String(used ?? field.default ?? "")}
        onChange={({ currentTarget }) => {
          const number = currentTarget.valueAsNumber;
          if (currentTarget.reportValidity()) set(Number.isNaN(number) ? undefined : number);
        }}
      />
      <Help>
        {field.description}
        {minimum !== undefined && maximum !== undefined && ` (${minimum} to ${maximum.toLocaleString("en")})`}
      </Help>
    </label>
  );
}

/** Several numbers that are said together or not at all. */
function Numbers({ name, field, value, used, set }: Of<"numbers">) {
  const shown = Array.isArray(value) ? value.join(", ") : "";
  return (
    <label class="field">
      <span>{worded(name)}</span>
      <input
        value={shown}
        placeholder={Array.isArray(used) ? used.join(", ") : `${field.count} numbers`}
        onChange={({ currentTarget }) => {
          const numbers = currentTarget.value
            .split(/[\s,]+/)
            .filter(Boolean)
            .map(Number);
          const isRight = numbers.length === field.count && numbers.every(Number.isFinite);
          currentTarget.setCustomValidity(isRight || numbers.length === 0 ? "" : `${field.count} numbers, with commas`);
          if (currentTarget.reportValidity()) set(isRight ? numbers : undefined);
        }}
      />
      <Help>{field.description}</Help>
    </label>
  );
}

function JsonInput({ name, field, value, set }: Props) {
  return (
    <label class="field wide">
      <span>{worded(name)}</span>
      <textarea
        rows={2}
        spellcheck={false}
        value={value === undefined ? "" : JSON.stringify(value)}
        placeholder="JSON"
        onChange={({ currentTarget }) => {
          const { isRight, parsed } = parse(currentTarget.value);
          currentTarget.setCustomValidity(isRight ? "" : "this is no JSON");
          if (currentTarget.reportValidity()) set(parsed);
        }}
      />
      <Help>{field.description}</Help>
    </label>
  );
}

function parse(text: string): { isRight: boolean; parsed: unknown } {
  if (text.trim() === "") return { isRight: true, parsed: undefined };
  try {
    return { isRight: true, parsed: JSON.parse(text) };
  } catch {
    return { isRight: false, parsed: undefined };
  }
}

function Fields({ name, field, fields, value, used, set }: Props & { fields: Record<string, Field> }) {
  return (
    <fieldset>
      <legend>{worded(name)}</legend>
      {field.description && <p class="hint">{field.description}</p>}
      <div class="fields">
        <Members fields={fields} value={value} used={used} set={set} />
      </div>
    </fieldset>
  );
}

/** The fields of a group, each by itself. */
function Members({
  fields,
  value,
  used,
  set,
}: { fields: Record<string, Field> } & Pick<Props, "value" | "used"> & { set: (group: Group | undefined) => void }) {
  return Object.entries(fields).map(([key, inner]) => (
    <FieldInput
      key={key}
      name={key}
      field={inner}
      value={member(value, key)}
      used={member(used, key)}
      set={(next) => set(withMember(value, key, next))}
    />
  ));
}

/** A word that says which, and the fields that belong to it. */
function Variants({ name, field: { tag, variants, description }, value, used, set }: Of<"variants">) {
  const word = member(value, tag) as string | undefined;
  const by = member(used, tag) as string | undefined;
  const fields = variants[word ?? by ?? ""] ?? {};
  const id = useId();
  return (
    <fieldset>
      <legend id={id}>{worded(name)}</legend>
      {description && <p class="hint">{description}</p>}
      <div class="fields">
        <label class="field">
          <span>{worded(tag)}</span>
          <select
            value={word ?? ""}
            aria-describedby={id}
            onChange={({ currentTarget }) => set(currentTarget.value ? { [tag]: currentTarget.value } : undefined)}
          >
            <option value="">{byPreset(by)}</option>
            {Object.keys(variants).map((variant) => (
              <option key={variant}>{variant}</option>
            ))}
          </select>
        </label>
        <Members
          fields={fields}
          value={value}
          used={(word ?? by) === by ? used : undefined}
          set={(next) => set(next && { [tag]: word ?? by, ...next })}
        />
      </div>
    </fieldset>
  );
}

const Help = ({ children }: { children: preact.ComponentChildren }) => <small class="hint">{children}</small>;

export const member = (value: Value, name: string): Value => (value as Group | undefined | null)?.[name] ?? undefined;

/** The group with a member set or left out; nothing where it has none. */
export function withMember(value: Value, name: string, next: Value): Group | undefined {
  const { [name]: _, ...others } = (value ?? {}) as Group;
  const group = next === undefined ? others : { ...others, [name]: next };
  return Object.keys(group).length > 0 ? group : undefined;
}
