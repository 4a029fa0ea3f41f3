//! The keys of the document: what has to come with a call where the server asks for keys.

use serde_json::{Value, json};

use super::operations;
use crate::http::admission::is_open;
use crate::http::links;

/// Adds the scheme of the keys, and says which calls need one. None is needed where the server asks for none, which the
/// document cannot know: a call without is always among what is allowed.
pub(super) fn add(document: &mut Value) {
    document["components"]["securitySchemes"] = json!({
        "key": {
            "type": "http",
            "scheme": "bearer",
            "description": "a key, where the server asks for keys",
        },
        "signature": {
            "type": "apiKey",
            "in": "query",
            "name": "signature",
            "description": "for a GET at one resource and below, in place of a key: from its `links`",
        },
    });
    document["security"] = json!([{"key": []}, {}]);
    for (method, path, call) in operations(document) {
        if is_open(path) {
            call["security"] = json!([]);
        } else if method == "get" && links::resource(path).is_some() {
            call["security"] = json!([{"key": []}, {"signature": []}, {}]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::document;
    use super::*;

    #[test]
    fn calls_say_what_they_need() {
        let mut document = document();
        let mut with = |security: Value| -> Vec<String> {
            let calls = operations(&mut document).filter(|(_, _, call)| call["security"] == security);
            calls.map(|(method, path, _)| format!("{method} {path}")).collect()
        };
        assert_eq!(with(json!([])), ["get /healthz", "get /readyz"]);
        let signed = with(json!([{"key": []}, {"signature": []}, {}]));
        let has = |call: &str| signed.iter().any(|signed| signed == call);
        assert!(has("get /v1/matches/{id}/events") && has("get /v1/meshes/{id}/picture"), "{signed:?}");
        assert!(!has("get /v1/matches/{id}/links") && !has("post /v1/matches/{id}/cancel"), "{signed:?}");
    }
}
