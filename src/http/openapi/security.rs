//! The keys of the document: what has to come with a call where the server asks for keys.

use serde_json::{Value, json};

use super::operations;
use crate::http::admission::is_open;

/// Adds the scheme of the keys, and says which calls need one. None is needed where the server asks for none, which the
/// document cannot know: a call without is always among what is allowed.
pub(super) fn add(document: &mut Value) {
    document["components"]["securitySchemes"] = json!({
        "key": {
            "type": "http",
            "scheme": "bearer",
            "description": "a key, where the server asks for keys",
        },
    });
    document["security"] = json!([{"key": []}, {}]);
    for (_, path, call) in operations(document) {
        if is_open(path) {
            call["security"] = json!([]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::document;
    use super::*;

    #[test]
    fn calls_that_are_open_say_so() {
        let mut document = document();
        let open: Vec<String> = operations(&mut document)
            .filter(|(_, _, call)| call["security"] == json!([]))
            .map(|(_, path, _)| path.to_owned())
            .collect();
        assert_eq!(open, ["/healthz", "/readyz"]);
    }
}
