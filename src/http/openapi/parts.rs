//! Objects that are written as parts: whole ones in their place, for generators of clients do not put parts together.

use serde_json::{Map, Value, json};

/// Makes one object of every `allOf`, and of one that has a union among its parts a union of objects.
pub(super) fn join(document: &mut Value) {
    let schemas = document.pointer("/components/schemas").and_then(Value::as_object).cloned().unwrap_or_default();
    join_within(document, &schemas);
}

fn join_within(value: &mut Value, schemas: &Map<String, Value>) {
    match value {
        Value::Array(items) => items.iter_mut().for_each(|item| join_within(item, schemas)),
        Value::Object(members) => {
            if let Some(Value::Array(parts)) = members.remove("allOf") {
                let whole = parts.into_iter().map(|part| resolved(part, schemas)).reduce(|a, b| joined(&a, &b));
                // What is said of the whole stays.
                for (name, member) in whole.as_ref().and_then(Value::as_object).into_iter().flatten() {
                    members.entry(name).or_insert_with(|| member.clone());
                }
            }
            members.values_mut().for_each(|member| join_within(member, schemas));
        }
        _ => {}
    }
}

/// The schema itself where `part` is a reference, whole.
fn resolved(part: Value, schemas: &Map<String, Value>) -> Value {
    let name = part["$ref"].as_str().and_then(|reference| reference.rsplit('/').next());
    let mut schema = match name {
        Some(name) => schemas.get(name).cloned().unwrap_or_default(),
        None => part,
    };
    let is_parts = |variant: &Value| variant.get("$ref").is_some() || variant.get("allOf").is_some();
    if let Some(variants) = schema.get_mut("oneOf").and_then(Value::as_array_mut) {
        for variant in variants.iter_mut().filter(|variant| is_parts(variant)) {
            *variant = resolved(variant.take(), schemas);
        }
    }
    join_within(&mut schema, schemas);
    schema
}

/// An object with the members of both.
fn joined(a: &Value, b: &Value) -> Value {
    let each = |variants: &[Value], join: &dyn Fn(&Value) -> Value| json!({"oneOf": variants.iter().map(join).collect::<Vec<_>>()});
    match (a["oneOf"].as_array(), b["oneOf"].as_array()) {
        (Some(variants), _) => each(variants, &|variant| joined(variant, b)),
        (None, Some(variants)) => each(variants, &|variant| joined(a, variant)),
        (None, None) => {
            let mut whole = a.clone();
            if let (Some(properties), Some(others)) = (whole["properties"].as_object_mut(), b["properties"].as_object())
            {
                properties.extend(others.clone());
            }
            let required = [a, b].into_iter().filter_map(|part| part["required"].as_array()).flatten();
            whole["required"] = required.cloned().collect();
            whole
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::document;
    use super::*;

    #[test]
    fn an_object_with_the_members_of_a_union_is_a_union_of_objects() {
        let document = document();
        let reference = document["components"]["schemas"]["Parameter"]["discriminator"]["mapping"]["integer"].as_str();
        let integer = document.pointer(&reference.unwrap()[1..]).unwrap();
        assert_eq!(integer["properties"]["type"]["enum"], json!(["integer"]));
        for member in ["name", "description", "minimum"] {
            assert!(integer["properties"][member].is_object(), "{member}");
            assert!(integer["required"].as_array().unwrap().contains(&json!(member)), "{member}");
        }
    }

    #[test]
    fn no_object_is_left_in_parts() {
        let document = document();
        assert!(!document.to_string().contains("\"allOf\""));
        let mesh = &document["components"]["schemas"]["ShapeDocument_MeshMeasures"];
        for member in ["id", "created_at", "vertices", "closed", "warnings"] {
            assert!(mesh["properties"][member].is_object(), "{member}");
            assert!(mesh["required"].as_array().unwrap().contains(&json!(member)), "{member}");
        }
    }
}
