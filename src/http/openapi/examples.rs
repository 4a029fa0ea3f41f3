//! Examples of the document, which work as they stand.

use serde_json::{Value, json};

use super::operation;

/// A house: an outline that is taken as it is.
const OUTLINE: [[f64; 2]; 7] = [[0.0, 0.0], [4.0, 0.0], [4.0, 3.0], [5.0, 3.0], [2.0, 5.0], [-1.0, 3.0], [0.0, 3.0]];

/// Adds examples to the bodies of requests.
pub(super) fn add(document: &mut Value) {
    let requests = [("upload_sketch", json!({"outline": OUTLINE}))];
    for (id, example) in requests {
        if let Some(call) = operation(document, id) {
            call["requestBody"]["content"]["application/json"]["example"] = example;
        }
    }
}
