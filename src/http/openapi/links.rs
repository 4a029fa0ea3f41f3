//! Links of the document: which calls can be made with what another has answered.

use serde_json::{Value, json};

use super::operation;

/// What one call answers for others.
struct Link {
    from: &'static str,
    /// Statuses of answers that have it.
    statuses: &'static [&'static str],
    /// Where it is in the answer.
    expression: &'static str,
    /// The path parameter it is good for.
    parameter: &'static str,
    to: &'static [&'static str],
}

const OF_MESH: &[&str] = &[
    "read_mesh",
    "read_mesh_geometry",
    "read_mesh_components",
    "read_mesh_spectrum",
    "read_mesh_functions",
    "read_mesh_segmentation",
    "rebuild_mesh",
    "sign_mesh",
    "draw_mesh",
    "rename_mesh",
    "delete_mesh",
];
const OF_SKETCH: &[&str] = &[
    "read_sketch",
    "read_sketch_geometry",
    "read_sketch_spectrum",
    "read_sketch_functions",
    "read_sketch_segmentation",
    "rebuild_sketch",
    "sign_sketch",
    "draw_sketch",
    "rename_sketch",
    "delete_sketch",
];
const OF_MATCH: &[&str] = &[
    "read_match",
    "follow_match",
    "read_result",
    "draw_match",
    "draw_matrix",
    "read_match_mesh",
    "read_inside",
    "read_inverse",
    "evaluate_match",
    "transfer",
    "sign_match",
    "cancel_match",
    "end_match",
];

const OF_POSE: &[&str] = &[
    "read_pose",
    "follow_pose",
    "read_pose_result",
    "read_pose_basis",
    "draw_pose",
    "sign_pose",
    "cancel_pose",
    "end_pose",
];

const LINKS: &[Link] = &[
    Link::by_id("upload_mesh", &["200", "201"], OF_MESH),
    Link::by_id("upload_sketch", &["200", "201"], OF_SKETCH),
    Link::by_id("create_match", &["200", "202"], OF_MATCH),
    Link::by_id("create_pose", &["200", "202"], OF_POSE),
    Link::by_first_id("list_meshes", OF_MESH),
    Link::by_first_id("list_sketches", OF_SKETCH),
    Link::by_first_id("list_matches", OF_MATCH),
    Link::by_first_id("list_poses", OF_POSE),
    Link {
        from: "list_examples",
        statuses: &["200"],
        expression: "$response.body#/0/name",
        parameter: "name",
        to: &["read_example_mesh", "read_example_sketch"],
    },
    Link {
        from: "list_regularisers",
        statuses: &["200"],
        expression: "$response.body#/0/type",
        parameter: "type",
        to: &["read_regulariser"],
    },
];

impl Link {
    /// From an answer that is one resource with an id.
    const fn by_id(from: &'static str, statuses: &'static [&'static str], to: &'static [&'static str]) -> Link {
        Link { from, statuses, expression: "$response.body#/id", parameter: "id", to }
    }

    /// From a list, of its first item.
    const fn by_first_id(from: &'static str, to: &'static [&'static str]) -> Link {
        Link { from, statuses: &["200"], expression: "$response.body#/items/0/id", parameter: "id", to }
    }
}

/// Adds every link to the answers it comes from.
pub(super) fn add(document: &mut Value) {
    for Link { from, statuses, expression, parameter, to } in LINKS {
        let Some(call) = operation(document, from) else { continue };
        for status in *statuses {
            for target in *to {
                call["responses"][status]["links"][target] =
                    json!({"operationId": target, "parameters": {*parameter: expression}});
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{document, operations};
    use super::*;

    #[test]
    fn links_lead_from_answers_there_are_to_calls_there_are() {
        let mut document = document();
        for Link { from, statuses, to, parameter, .. } in LINKS {
            let call = operation(&mut document, from).unwrap();
            assert!(statuses.iter().all(|status| call["responses"][status]["description"].is_string()), "{from}");
            for target in *to {
                let call = operation(&mut document, target).unwrap();
                let mut parameters = call["parameters"].as_array().unwrap().iter();
                assert!(parameters.any(|found| found["name"] == json!(parameter)), "{target}");
            }
        }
    }

    #[test]
    fn every_call_with_an_identifier_can_be_reached() {
        let reached: Vec<&str> = LINKS.iter().flat_map(|link| link.to).copied().collect();
        for (method, path, call) in operations(&mut document()) {
            let id = call["operationId"].as_str().unwrap();
            assert!(!path.contains('{') || reached.contains(&id), "{method} {path}");
        }
    }
}
