/** The schema of a request, as the server describes it, resolved to what a form needs. */
import { json } from "../api/call";

/** A part of a JSON schema, as far as the server's have it. */
interface Schema {
  $ref?: string;
  oneOf?: Schema[];
  discriminator?: { propertyName: string; mapping: Record<string, string> };
  type?: string | string[];
  enum?: string[];
  properties?: Record<string, Schema>;
  items?: Schema;
  description?: string;
  default?: unknown;
  minimum?: number;
  maximum?: number;
  minItems?: number;
  maxItems?: number;
}

/** A field of the form. */
export type Field = { description: string } & (
  | { kind: "choice"; words: string[] }
  | { kind: "number"; isInteger: boolean; minimum?: number; maximum?: number; default?: unknown }
  | { kind: "numbers"; count: number }
  | { kind: "fields"; fields: Record<string, Field> }
  /** One of several groups of fields, by the word in `tag`. */
  | { kind: "variants"; tag: string; variants: Record<string, Record<string, Field>> }
  | { kind: "json" }
);

interface Document {
  components: { schemas: Record<string, Schema> };
}

/** The fields of a match request. */
export async function requestFields(): Promise<Record<string, Field>> {
  const document = await json<Document>("/openapi.json");
  return fieldsOf(document, document.components.schemas.MatchRequest ?? {}, null);
}

function fieldsOf(document: Document, schema: Schema, tag: string | null): Record<string, Field> {
  const entries = Object.entries(schema.properties ?? {}).filter(([name]) => name !== tag);
  return Object.fromEntries(entries.map(([name, property]) => [name, fieldOf(document, property)]));
}

function fieldOf(document: Document, schema: Schema): Field {
  const whole = resolved(document, schema);
  const description = schema.description ?? whole.description ?? "";
  if (whole.discriminator) {
    const { propertyName: tag, mapping } = whole.discriminator;
    const variants = Object.entries(mapping).map(([word, $ref]) => {
      return [word, fieldsOf(document, resolved(document, { $ref }), tag)] as const;
    });
    return { kind: "variants", tag, variants: Object.fromEntries(variants), description };
  }
  if (whole.enum) return { kind: "choice", words: whole.enum, description };
  const types = [whole.type ?? []].flat();
  if (types.includes("integer") || types.includes("number")) {
    const { minimum, maximum } = whole;
    const limits = { ...(minimum !== undefined && { minimum }), ...(maximum !== undefined && { maximum }) };
    return { kind: "number", isInteger: types.includes("integer"), ...limits, default: whole.default, description };
  }
  if (whole.properties) return { kind: "fields", fields: fieldsOf(document, whole, null), description };
  if (types.includes("array") && whole.minItems !== undefined && whole.minItems === whole.maxItems) {
    return { kind: "numbers", count: whole.minItems, description };
  }
  return { kind: "json", description };
}

/** What a reference names, and of an optional value what it is where it is there. */
function resolved(document: Document, schema: Schema): Schema {
  const name = schema.$ref?.split("/").pop();
  if (name) return resolved(document, document.components.schemas[name] ?? {});
  const there = schema.oneOf?.filter(({ type }) => type !== "null") ?? [];
  return !schema.discriminator && there.length === 1 && there[0] ? resolved(document, there[0]) : schema;
}
