//! What every call of the document has: bodies with schemas, the problem it may answer.

use serde_json::{Map, Value, json};

use super::operations;
use crate::http::problem;

/// Adds to every call what its handler does not say: a body that is asked for is required and not empty, one that is no
/// JSON and no text is bytes, a stream is of events, and whatever fails answers a problem. A parameter that may be left out
/// is no null.
pub(super) fn complete(document: &mut Value) {
    operations(document).for_each(|(_, _, call)| complete_call(call));
}

fn complete_call(call: &mut Value) {
    for parameter in call.get_mut("parameters").and_then(Value::as_array_mut).into_iter().flatten() {
        forbid_null(&mut parameter["schema"]);
    }
    if let Some(request) = call.get_mut("requestBody") {
        request["required"] = json!(true);
        type_bytes(request, &file());
        if let Some(form) = request["content"].get_mut("multipart/form-data") {
            form["schema"] = json!({
                "type": "object",
                "properties": {"file": file()},
                "required": ["file"],
                "additionalProperties": false,
            });
        }
    }
    let Some(responses) = call.get_mut("responses").and_then(Value::as_object_mut) else { return };
    for response in responses.values_mut() {
        type_bytes(response, &bytes());
        type_events(response);
    }
    add_problems(responses);
}

/// The schema of bytes that are neither JSON nor text, as generators of clients understand it.
fn bytes() -> Value {
    json!({"type": "string", "format": "binary"})
}

/// The schema of the bytes of a file, of which there is at least one.
fn file() -> Value {
    json!({"type": "string", "format": "binary", "minLength": 1})
}

/// Gives the contents of a body that say nothing of their shape the schema `bytes`.
fn type_bytes(body: &mut Value, bytes: &Value) {
    for content in body.get_mut("content").and_then(Value::as_object_mut).into_iter().flat_map(Map::values_mut) {
        if content.get("schema").is_none() {
            content["schema"] = bytes.clone();
        }
    }
}

/// Makes the schema of what the events of a stream carry the schema of an event: an object of its fields.
fn type_events(response: &mut Value) {
    let Some(schema) = response.pointer_mut("/content/text~1event-stream/schema") else { return };
    let carried = schema.take();
    *schema = json!({
        "type": "object",
        "properties": {
            "event": {"type": "string"},
            "id": {"type": "string"},
            "data": {"type": "string", "contentMediaType": "application/json", "contentSchema": carried},
        },
        "required": ["event", "id", "data"],
    });
}

fn add_problems(responses: &mut Map<String, Value>) {
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

#[cfg(test)]
mod tests {
    use super::super::document;
    use super::*;

    #[test]
    fn every_call_may_answer_a_problem() {
        for (method, path, call) in operations(&mut document()) {
            assert!(call["responses"]["default"]["content"][problem::MEDIA_TYPE].is_object(), "{method} {path}");
        }
    }

    #[test]
    fn every_body_is_required_and_has_a_schema() {
        for (method, path, call) in operations(&mut document()) {
            let request = call.get("requestBody").inspect(|request| assert_eq!(request["required"], json!(true)));
            let responses = call["responses"].as_object().unwrap().values();
            for (media_type, content) in
                responses.chain(request).filter_map(|body| body["content"].as_object()).flatten()
            {
                assert!(content["schema"].is_object(), "{method} {path}: {media_type}");
            }
        }
    }

    #[test]
    fn parameters_are_never_null() {
        let mut document = document();
        let parameters = operations(&mut document).flat_map(|(_, _, call)| call["parameters"].as_array()).flatten();
        let types: Vec<&Value> = parameters.map(|parameter| &parameter["schema"]["type"]).collect();
        assert!(!types.is_empty() && types.iter().all(|kind| !kind.is_array()), "{types:?}");
    }
}
