//! The OpenAPI document, made of the handlers.

use axum::Router;
use serde_json::{Map, Value, json};
use utoipa::OpenApi;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::problem::{self, Problem};
use super::{App, events, health, matches, meshes, pictures, regularisers, results, sketches, spectra};

#[derive(OpenApi)]
#[openapi(
    info(description = "Matches 2D sketches to 3D meshes by functional maps"),
    tags(
        (name = "meshes", description = "3D meshes"),
        (name = "sketches", description = "2D sketches"),
        (name = "matches", description = "which point of the mesh is each point of the sketch"),
        (name = "regularisers", description = "what can be added to the problem"),
        (name = "service", description = "the state of the server"),
    ),
    components(schemas(Problem)),
)]
struct Frame;

/// Every route beside the document that describes it.
pub(super) fn routes() -> (Router<App>, Value) {
    let router = OpenApiRouter::with_openapi(Frame::openapi())
        .routes(routes!(meshes::upload, meshes::list))
        .routes(routes!(meshes::read))
        .routes(routes!(meshes::geometry))
        .routes(routes!(meshes::components))
        .routes(routes!(spectra::of_mesh))
        .routes(routes!(sketches::upload, sketches::list))
        .routes(routes!(sketches::read))
        .routes(routes!(sketches::geometry))
        .routes(routes!(spectra::of_sketch))
        .routes(routes!(matches::create, matches::list))
        .routes(routes!(matches::read, matches::end))
        .routes(routes!(results::read))
        .routes(routes!(pictures::of_match))
        .routes(routes!(pictures::of_matrix))
        .routes(routes!(pictures::of_mesh))
        .routes(routes!(events::stream))
        .routes(routes!(regularisers::list))
        .routes(routes!(regularisers::read))
        .routes(routes!(health::alive))
        .routes(routes!(health::ready))
        .routes(routes!(health::measures));
    let (router, document) = router.split_for_parts();
    (router, finished(serde_json::to_value(document).unwrap_or_default()))
}

/// The OpenAPI 3.1 document as it is served and committed.
pub fn document() -> Value {
    routes().1
}

/// The document with what the handlers do not say one by one, and which variant of a tagged union a tag stands for.
fn finished(mut document: Value) -> Value {
    let paths = document["paths"].as_object_mut().into_iter().flat_map(Map::values_mut);
    paths.filter_map(Value::as_object_mut).flat_map(Map::values_mut).for_each(complete);
    if let Some(schemas) = document.pointer_mut("/components/schemas").and_then(Value::as_object_mut) {
        let unions: Vec<String> = schemas.keys().cloned().collect();
        for name in unions {
            name_variants(schemas, &name);
        }
    }
    document
}

/// Adds to a call the problem it may answer and the part of a form it takes; a parameter that may be left out is no
/// null.
fn complete(call: &mut Value) {
    for parameter in call.get_mut("parameters").and_then(Value::as_array_mut).into_iter().flatten() {
        forbid_null(&mut parameter["schema"]);
    }
    if let Some(form) = call.pointer_mut("/requestBody/content/multipart~1form-data") {
        let file = json!({"type": "string", "format": "binary"});
        form["schema"] = json!({"type": "object", "properties": {"file": file}, "required": ["file"]});
    }
    let Some(responses) = call.get_mut("responses").and_then(Value::as_object_mut) else { return };
    let problem = json!({
        "description": "a problem (RFC 9457)",
        "content": {problem::MEDIA_TYPE: {"schema": {"$ref": "#/components/schemas/Problem"}}},
    });
    responses.entry("default").or_insert_with(|| problem.clone());
    for (status, response) in responses.iter_mut() {
        if status.starts_with(['4', '5']) {
            response["content"] = problem["content"].clone();
        }
    }
}

/// Takes `null` out of the types a schema allows.
fn forbid_null(schema: &mut Value) {
    let Some(types) = schema.get_mut("type").and_then(Value::as_array_mut) else { return };
    types.retain(|name| name != "null");
    if let [only] = types.as_slice() {
        schema["type"] = only.clone();
    }
}

/// Gives every variant of the tagged union `name` a schema of its own, which a discriminator can point to. Schemas that
/// are no tagged union stay as they are.
fn name_variants(schemas: &mut Map<String, Value>, name: &str) {
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
    use super::*;

    #[test]
    fn every_call_may_answer_a_problem() {
        let document = document();
        for (path, calls) in document["paths"].as_object().unwrap() {
            for (method, call) in calls.as_object().unwrap() {
                assert!(call["responses"]["default"]["content"][problem::MEDIA_TYPE].is_object(), "{method} {path}");
            }
        }
    }

    #[test]
    fn every_reference_leads_somewhere() {
        let document = document();
        for reference in document.to_string().split("\"#").skip(1).filter_map(|rest| rest.split('"').next()) {
            assert!(document.pointer(reference).is_some(), "{reference}");
        }
    }

    #[test]
    fn parameters_are_never_null() {
        let key = &document()["paths"]["/v1/matches"]["post"]["parameters"][1];
        assert_eq!((&key["name"], &key["schema"]["type"]), (&json!("Idempotency-Key"), &json!("string")));
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
