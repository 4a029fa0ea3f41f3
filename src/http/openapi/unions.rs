//! Tagged unions: which variant a tag stands for.

use serde_json::{Map, Value, json};

/// Gives every variant of every tagged union a schema of its own, which a discriminator can point to. Schemas that are no
/// tagged union stay as they are.
pub(super) fn name_variants(document: &mut Value) {
    let Some(schemas) = document.pointer_mut("/components/schemas").and_then(Value::as_object_mut) else { return };
    let names: Vec<String> = schemas.keys().cloned().collect();
    for name in names {
        name_variants_of(schemas, &name);
    }
}

fn name_variants_of(schemas: &mut Map<String, Value>, name: &str) {
    let Some(variants) = schemas[name].get("oneOf").and_then(Value::as_array).cloned() else { return };
    let Some(tags) = variants.iter().map(tag).collect::<Option<Vec<(String, String)>>>() else { return };
    let Some((property, _)) = tags.first().cloned() else { return };
    let (mut references, mut mapping) = (Vec::new(), Map::new());
    for (mut variant, (_, value)) in variants.into_iter().zip(tags) {
        // A generator that reads the tag for itself would take it for a property too many.
        variant.as_object_mut().map(|variant| variant.remove("additionalProperties"));
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
    fn unions_tell_their_variants_by_the_tag() {
        let document = document();
        let regulariser = &document["components"]["schemas"]["Regulariser"];
        assert_eq!(regulariser["discriminator"]["propertyName"], "type");
        let l1 = regulariser["discriminator"]["mapping"]["l1"].as_str().unwrap();
        assert_eq!(document.pointer(&l1[1..]).unwrap()["properties"]["type"]["enum"], json!(["l1"]));
    }
}
