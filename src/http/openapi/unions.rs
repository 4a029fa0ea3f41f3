//! Tagged unions: which variant a tag stands for.

use serde_json::{Map, Value, json};

/// Gives every variant of every tagged union a schema of its own, which a discriminator can point to. Schemas that are no
/// tagged union stay as they are.
pub(super) fn name_variants(document: &mut Value) {
    let Some(schemas) = document.pointer_mut("/components/schemas").and_then(Value::as_object_mut) else { return };
    let names: Vec<String> = schemas.keys().cloned().collect();
    for name in names {
        distribute(schemas, &name);
        name_variants_of(schemas, &name);
    }
}

/// Makes an object that has the members of a union beside its own a union of whole objects: generators of clients do not
/// put such parts together.
fn distribute(schemas: &mut Map<String, Value>, name: &str) {
    let resolved = |part: &Value| match part["$ref"].as_str().and_then(|reference| reference.rsplit('/').next()) {
        Some(name) => schemas.get(name).cloned().unwrap_or_default(),
        None => part.clone(),
    };
    let parts: Vec<Value> = schemas[name]["allOf"].as_array().into_iter().flatten().map(resolved).collect();
    let [union, own] = parts.as_slice() else { return };
    let Some(variants) = union["oneOf"].as_array() else { return };
    let variants: Vec<Value> = variants.iter().map(resolved).map(|variant| merged(variant, own)).collect();
    if let Some(schema) = schemas.get_mut(name).and_then(Value::as_object_mut) {
        schema.remove("allOf");
        schema.insert("oneOf".to_owned(), Value::Array(variants));
    }
}

/// An object with the members of another beside its own.
fn merged(mut object: Value, other: &Value) -> Value {
    if let (Some(properties), Some(others)) = (object["properties"].as_object_mut(), other["properties"].as_object()) {
        properties.extend(others.clone());
    }
    if let (Some(required), Some(others)) = (object["required"].as_array_mut(), other["required"].as_array()) {
        required.extend(others.iter().cloned());
    }
    object
}

fn name_variants_of(schemas: &mut Map<String, Value>, name: &str) {
    let Some(variants) = schemas[name].get("oneOf").and_then(Value::as_array).cloned() else { return };
    let Some(tags) = variants.iter().map(tag).collect::<Option<Vec<(String, String)>>>() else { return };
    let Some((property, _)) = tags.first().cloned() else { return };
    let (mut references, mut mapping) = (Vec::new(), Map::new());
    for (variant, (_, value)) in variants.into_iter().zip(tags) {
        let variant_name = format!("{name}{}", camel_case(&value));
        let reference = format!("#/components/schemas/{variant_name}");
        references.push(json!({"$ref": reference}));
        mapping.insert(value, Value::String(reference));
        schemas.insert(variant_name, variant);
    }
    schemas[name]["oneOf"] = Value::Array(references);
    schemas[name]["discriminator"] = json!({"propertyName": property, "mapping": mapping});
}

/// The property whose only value tells a variant from the others, and the value.
fn tag(variant: &Value) -> Option<(String, String)> {
    let properties = variant.get("properties")?.as_object()?;
    properties.iter().find_map(|(name, schema)| {
        let [only] = schema.get("enum")?.as_array()?.as_slice() else { return None };
        Some((name.clone(), only.as_str()?.to_owned()))
    })
}

fn camel_case(snake_case: &str) -> String {
    let word =
        |word: &str| word.chars().take(1).flat_map(char::to_uppercase).chain(word.chars().skip(1)).collect::<String>();
    snake_case.split('_').map(word).collect()
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
    fn unions_tell_their_variants_by_the_tag() {
        let document = document();
        let regulariser = &document["components"]["schemas"]["Regulariser"];
        assert_eq!(regulariser["discriminator"]["propertyName"], "type");
        let l1 = regulariser["discriminator"]["mapping"]["l1"].as_str().unwrap();
        assert_eq!(document.pointer(&l1[1..]).unwrap()["properties"]["type"]["enum"], json!(["l1"]));
    }
}
