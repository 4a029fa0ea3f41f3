//! The OpenAPI document, made of the handlers.

mod calls;
mod examples;
mod links;
mod parts;
mod security;
mod unions;

use axum::Router;
use serde_json::{Value, json};
use utoipa::OpenApi;
use utoipa_axum::router::OpenApiRouter;
use utoipa_axum::routes;

use super::problem::Problem;
use super::{
    Service, evaluations, events, examples as creatures, functions, geometry, health, inside, links as signed, matches,
    meshes, pictures, portraits, pose_results, poses, rebuilt, regularisers, results, segmentation, sketches, spectra,
    sweeps, transfers,
};

#[derive(OpenApi)]
#[openapi(
    info(description = "Matches 2D sketches to 3D meshes by functional maps"),
    servers((url = "/", description = "the server that answers this document")),
    tags(
        (name = "meshes", description = "3D meshes"),
        (name = "sketches", description = "2D sketches"),
        (name = "matches", description = "which point of the mesh is each point of the sketch"),
        (name = "poses", description = "the mesh posed by its sketch"),
        (name = "examples", description = "creatures to try the service with"),
        (name = "regularisers", description = "what can be added to the problem"),
        (name = "service", description = "the state of the server"),
    ),
    components(schemas(Problem)),
)]
struct Head;

/// Every route beside the document that describes it.
pub(super) fn routes() -> (Router<Service>, Value) {
    let router = OpenApiRouter::with_openapi(Head::openapi())
        .routes(routes!(meshes::upload, meshes::list))
        .routes(routes!(meshes::read, meshes::rename, meshes::delete))
        .routes(routes!(meshes::components))
        .routes(routes!(signed::of_mesh))
        .routes(routes!(signed::of_sketch))
        .routes(routes!(signed::of_match))
        .routes(routes!(signed::of_pose))
        .routes(routes!(geometry::of_mesh))
        .routes(routes!(portraits::of_mesh))
        .routes(routes!(portraits::of_sketch))
        .routes(routes!(spectra::of_mesh))
        .routes(routes!(functions::of_mesh))
        .routes(routes!(segmentation::of_mesh))
        .routes(routes!(rebuilt::of_mesh))
        .routes(routes!(sketches::upload, sketches::list))
        .routes(routes!(sketches::read, sketches::rename, sketches::delete))
        .routes(routes!(geometry::of_sketch))
        .routes(routes!(spectra::of_sketch))
        .routes(routes!(functions::of_sketch))
        .routes(routes!(segmentation::of_sketch))
        .routes(routes!(rebuilt::of_sketch))
        .routes(routes!(matches::create, matches::list))
        .routes(routes!(sweeps::create))
        .routes(routes!(matches::read, matches::end))
        .routes(routes!(matches::cancel))
        .routes(routes!(results::read))
        .routes(routes!(evaluations::create))
        .routes(routes!(inside::read))
        .routes(routes!(transfers::create))
        .routes(routes!(transfers::inverse))
        .routes(routes!(pictures::of_match))
        .routes(routes!(pictures::of_matrix))
        .routes(routes!(pictures::of_mesh))
        .routes(routes!(events::of_match))
        .routes(routes!(poses::create, poses::list))
        .routes(routes!(poses::read, poses::end))
        .routes(routes!(poses::cancel))
        .routes(routes!(pose_results::read))
        .routes(routes!(pose_results::picture))
        .routes(routes!(pose_results::basis))
        .routes(routes!(events::of_pose))
        .routes(routes!(creatures::list))
        .routes(routes!(creatures::mesh))
        .routes(routes!(creatures::sketch))
        .routes(routes!(regularisers::list))
        .routes(routes!(regularisers::read))
        .routes(routes!(regularisers::terms))
        .routes(routes!(regularisers::bases))
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

/// The document with what the handlers do not say one by one.
fn finished(mut document: Value) -> Value {
    calls::complete(&mut document);
    links::add(&mut document);
    security::add(&mut document);
    examples::add(&mut document);
    parts::join(&mut document);
    unions::name_variants(&mut document);
    document
}

/// The calls of a document: the method, the path and the operation of each.
fn operations(document: &mut Value) -> impl Iterator<Item = (&str, &str, &mut Value)> {
    let paths = document["paths"].as_object_mut().into_iter().flatten();
    paths.flat_map(|(path, calls)| {
        let calls = calls.as_object_mut().into_iter().flatten();
        calls.map(move |(method, call)| (method.as_str(), path.as_str(), call))
    })
}

/// The operation of this identifier.
fn operation<'a>(document: &'a mut Value, id: &str) -> Option<&'a mut Value> {
    operations(document).map(|(_, _, call)| call).find(|call| call["operationId"] == json!(id))
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;

    #[test]
    fn every_call_has_an_identifier_of_its_own() {
        let mut seen = BTreeSet::new();
        for (method, path, call) in operations(&mut document()) {
            let id = call["operationId"].as_str().unwrap();
            assert!(seen.insert(id.to_owned()), "{method} {path}: {id} is taken");
        }
        assert!(seen.len() > 20);
    }

    #[test]
    fn every_form_is_told_of() {
        let mut document = document();
        for (id, forms) in [
            ("read_result", "application/json text/csv application/x-npy model/gltf-binary"),
            ("read_pose_result", "application/json model/obj model/gltf-binary"),
            ("read_mesh_spectrum", "application/json application/x-npy application/vnd.safetensors"),
            ("read_sketch_spectrum", "application/json application/x-npy application/vnd.safetensors"),
            ("read_mesh_geometry", "application/json application/vnd.safetensors application/x-npy model/gltf-binary"),
            ("read_sketch_geometry", "application/json application/vnd.safetensors application/x-npy"),
            ("read_example_sketch", "application/json image/svg+xml image/png"),
            ("upload_mesh", "model/obj model/stl model/gltf-binary application/octet-stream multipart/form-data"),
            ("upload_sketch", "application/json image/svg+xml image/png image/jpeg application/octet-stream"),
        ] {
            let body = if id.starts_with("upload") { "/requestBody" } else { "/responses/200" };
            let told = operation(&mut document, id).unwrap().pointer(body).unwrap()["content"].clone();
            for form in forms.split(' ') {
                assert!(told.get(form).is_some(), "{id}: {form}");
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
}
