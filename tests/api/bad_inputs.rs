//! What clients get wrong, and the answer to each: a problem that names the place, nothing stored, the server alive.

use image::{GrayImage, ImageFormat, Luma};
use reqwest::{Method, RequestBuilder};
use serde_json::{Value, json};
use sketchmatch::http::Config;

use crate::drawings::{SQUARE_SVG, disk, encoded};
use crate::server::{Server, problem_of};

/// A request that has to be refused.
struct Case {
    name: &'static str,
    method: Method,
    /// `{mesh}` and `{sketch}` stand for shapes that are there.
    path: String,
    headers: Vec<(&'static str, String)>,
    body: Vec<u8>,
    status: u16,
    /// The pointer of a fault, or a part of the name of its place; nothing where the status says it all.
    place: Option<&'static str>,
}

fn case(name: &'static str, method: Method, path: &str, status: u16, place: Option<&'static str>) -> Case {
    Case { name, method, path: path.to_owned(), headers: Vec::new(), body: Vec::new(), status, place }
}

impl Case {
    fn with(mut self, header: &'static str, value: &str) -> Case {
        self.headers.push((header, value.to_owned()));
        self
    }

    fn carrying(mut self, body: impl Into<Vec<u8>>) -> Case {
        self.body = body.into();
        self
    }

    fn request(&self, server: &Server, mesh: &str, sketch: &str) -> RequestBuilder {
        let filled = |text: &str| text.replace("{mesh}", mesh).replace("{sketch}", sketch);
        let body = match String::from_utf8(self.body.clone()) {
            Ok(text) => filled(&text).into_bytes(),
            Err(error) => error.into_bytes(),
        };
        let request = server.request(self.method.as_str(), &filled(&self.path));
        self.headers.iter().fold(request, |request, (name, value)| request.header(*name, value)).body(body)
    }

    fn is_named_by(&self, problem: &Value) -> bool {
        let Some(place) = self.place else { return true };
        problem["errors"].as_array().is_some_and(|faults| {
            faults
                .iter()
                .any(|fault| fault["pointer"] == place || fault["place"].as_str().is_some_and(|at| at.contains(place)))
        })
    }
}

fn mesh(name: &'static str, format: &str, file: impl Into<Vec<u8>>, place: &'static str) -> Case {
    case(name, Method::POST, &format!("/v1/meshes?format={format}"), 422, Some(place)).carrying(file)
}

fn outline(name: &'static str, status: u16, body: &str, place: &'static str) -> Case {
    let case = case(name, Method::POST, "/v1/sketches", status, Some(place));
    case.with("content-type", "application/json").carrying(body)
}

fn drawing(name: &'static str, media_type: &str, body: impl Into<Vec<u8>>) -> Case {
    case(name, Method::POST, "/v1/sketches", 422, None).with("content-type", media_type).carrying(body)
}

fn request(name: &'static str, besides: &str, place: &'static str) -> Case {
    let body = format!(r#"{{"mesh": "{{mesh}}", "sketch": "{{sketch}}", {besides}}}"#);
    let case = case(name, Method::POST, "/v1/matches", 422, Some(place));
    case.with("content-type", "application/json").carrying(body)
}

fn get(name: &'static str, path: &str, status: u16, place: Option<&'static str>) -> Case {
    case(name, Method::GET, path, status, place)
}

const CORNERS: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n";

fn meshes() -> Vec<Case> {
    let obj = |name, faces: &str, place| mesh(name, "obj", format!("{CORNERS}{faces}"), place);
    let mut stl = vec![0; 84];
    stl[80] = 200;
    vec![
        obj("no faces", "", "file"),
        obj("an index out of range", "f 1 2 9\n", "line 5"),
        obj("an index of zero", "f 0 1 2\n", "line 5"),
        obj("an index that is no number", "f 1 2 x\n", "line 5"),
        obj("a face of two corners", "f 1 2\n", "line 5"),
        obj("a corner twice", "f 1 1 2\n", "face 0"),
        mesh("three corners in a line", "obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "face 0"),
        mesh("a coordinate that is no number", "obj", "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "line 1"),
        mesh("an infinite coordinate", "obj", "v inf 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "line 1"),
        mesh("a vertex of two coordinates", "obj", "v 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "line 1"),
        mesh("OFF of another name", "off", "CAT\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", ""),
        mesh("OFF with more vertices than bytes", "off", "OFF\n4000000000 1 0\n0 0 0\n", "file"),
        mesh("OFF cut off", "off", "OFF\n3 1 0\n0 0 0\n1 0 0\n", ""),
        mesh("OFF with an index out of range", "off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", "face 0"),
        mesh("PLY without an end of its header", "ply", "ply\nformat ascii 1.0\nelement vertex 3\n", ""),
        mesh("PLY with more vertices than bytes", "ply", ply(1_000_000_000_000), ""),
        mesh("PLY without its bytes", "ply", ply(3), ""),
        mesh("STL of another length than it says", "stl", stl, ""),
        mesh("STL cut off", "stl", "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\n", ""),
        mesh("GLB that is none", "glb", "gLTF\x02\0\0\0", ""),
        mesh("GLB cut off", "glb", b"glTF\x02\0\0\0\xff\0\0\0\xf0\0\0\0JSON".to_vec(), ""),
    ]
}

fn ply(vertices: u64) -> String {
    format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\n\
         property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
    )
}

fn uploads() -> Vec<Case> {
    let upload = |name, query: &str, status, place| {
        case(name, Method::POST, &format!("/v1/meshes{query}"), status, place).carrying(CORNERS)
    };
    let form = |name, status, body: &str| {
        let case = case(name, Method::POST, "/v1/meshes", status, None);
        case.with("content-type", "multipart/form-data; boundary=b").carrying(body)
    };
    vec![
        case("no body", Method::POST, "/v1/meshes?format=obj", 400, Some("body")),
        upload("an unknown format", "?format=dae", 422, Some("query parameter format")),
        upload("an unknown parameter", "?format=obj&colour=red", 422, Some("query parameter colour")),
        upload("a parameter twice", "?format=obj&format=off", 422, Some("query parameter format")),
        upload(
            "a name without end",
            &format!("?format=obj&name={}", "n".repeat(201)),
            422,
            Some("query parameter name"),
        ),
        upload("a compressed body", "?format=obj", 415, Some("header content-encoding"))
            .with("content-encoding", "gzip"),
        upload("an empty key", "?format=obj", 400, Some("header idempotency-key")).with("idempotency-key", ""),
        case("bytes of no format", Method::POST, "/v1/meshes", 415, Some("header content-type"))
            .carrying("\x01\x02\x03"),
        case("a file too large", Method::POST, "/v1/meshes?format=obj", 413, None).carrying(vec![b'#'; 200_001]),
        case("too many triangles", Method::POST, "/v1/meshes?format=off", 413, None).carrying(many_triangles()),
        form("a form without a file", 400, "--b--\r\n"),
        form("a form that breaks off", 400, "--b\r\ncontent-disposition: form-data; name=\"file\"\r\n\r\nv 0"),
        form(
            "a form of another part",
            422,
            "--b\r\ncontent-disposition: form-data; name=\"mesh\"\r\n\r\nv\r\n--b--\r\n",
        ),
    ]
}

fn many_triangles() -> String {
    let vertices: String = (0..3003).map(|i| format!("{i} {} 0\n", i % 3)).collect();
    let faces: String = (0..3001).map(|i| format!("3 {i} {} {}\n", i + 1, i + 2)).collect();
    format!("OFF\n3003 3001 0\n{vertices}{faces}")
}

fn outlines() -> Vec<Case> {
    let points = |name, points: &str, place| outline(name, 422, &format!(r#"{{"outline": {points}}}"#), place);
    let holes = |name, holes: &str, place| {
        outline(name, 422, &format!(r#"{{"outline": [[0,0],[10,0],[10,10],[0,10]], "holes": {holes}}}"#), place)
    };
    let wanted = |name, vertices: &str| {
        outline(
            name,
            422,
            &format!(r#"{{"outline": [[0,0],[1,0],[0,1]], "target_vertices": {vertices}}}"#),
            "/target_vertices",
        )
    };
    vec![
        outline("no JSON", 400, "outline", ""),
        outline("an unfinished object", 400, r#"{"outline": [[0,0],"#, "/outline"),
        outline("two values", 400, r#"{"outline": [[0,0],[1,0],[0,1]]} {}"#, ""),
        outline("a key twice", 400, r#"{"outline": [[0,0],[1,0],[0,1]], "outline": []}"#, ""),
        outline("a number out of range", 400, r#"{"outline": [[0,0],[1e999,0],[0,1]]}"#, "/outline/1/0"),
        Case { place: None, ..outline("brackets without end", 400, &"[".repeat(100_000), "") },
        outline("no outline", 422, "{}", "/outline"),
        outline("an unknown member", 422, r#"{"outline": [[0,0],[1,0],[0,1]], "colour": 1}"#, "/colour"),
        outline("a list for an object", 422, "[]", ""),
        points("two points", "[[0,0],[1,0]]", "/outline"),
        points("one point often", "[[1,1],[1,1],[1,1],[1,1]]", "/outline"),
        points("points in a line", "[[0,0],[1,1],[2,2],[3,3]]", "/outline"),
        points("a figure of eight", "[[0,0],[10,10],[10,0],[0,10]]", "point"),
        points("a text for a coordinate", r#"[[0,0],["1",0],[0,1]]"#, "/outline/1/0"),
        points("three coordinates", "[[0,0],[1,0,0],[0,1]]", "/outline/1"),
        points("one coordinate", "[[0,0],[1],[0,1]]", "/outline/1"),
        points("no coordinate", "[[0,null],[1,0],[0,1]]", "/outline/0/1"),
        points("a figure of no size", "[[0,0],[1e-100,0],[0,1e-100]]", "/outline"),
        points("a huge coordinate", "[[0,0],[1e300,0],[0,1]]", "/outline/1"),
        holes("a hole outside", "[[[20,20],[21,20],[20,21]]]", "/holes/0"),
        holes("a hole across the outline", "[[[5,5],[15,5],[5,7]]]", "/holes/0"),
        holes("a hole in a hole", "[[[1,1],[9,1],[9,9],[1,9]],[[3,3],[4,3],[3,4]]]", "/holes/1"),
        holes("a hole of two points", "[[[1,1],[2,2]]]", "/holes/0"),
        wanted("too few vertices", "10"),
        wanted("too many vertices", "1000000"),
        wanted("half a vertex", "100.5"),
        wanted("a negative number of vertices", "-100"),
    ]
}

fn drawings() -> Vec<Case> {
    let png = encoded(disk(), ImageFormat::Png);
    let mut huge = png.clone();
    huge[16..24].copy_from_slice(&[0, 1, 0, 0, 0, 1, 0, 0]);
    let svg = |name, inside: &str| {
        drawing(
            name,
            "image/svg+xml",
            format!(r#"<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 9 9">{inside}</svg>"#),
        )
    };
    let two_numbers = "/v1/sketches?target_vertices=60";
    vec![
        drawing("no SVG", "image/svg+xml", "<html></html>"),
        drawing(
            "an SVG in UTF-16",
            "image/svg+xml",
            "\u{feff}<svg/>".encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<u8>>(),
        ),
        drawing("an SVG cut off", "image/svg+xml", &SQUARE_SVG.as_bytes()[..90]),
        svg("an SVG of nothing", ""),
        svg("groups without end", &("<g>".repeat(20_000) + &"</g>".repeat(20_000))),
        svg("a group within itself", r##"<g id="a"><use href="#a"/></g>"##),
        drawing(
            "an SVG of a file",
            "image/svg+xml",
            r#"<!DOCTYPE svg [<!ENTITY e SYSTEM "file:///etc/hostname">]><svg xmlns="http://www.w3.org/2000/svg">&e;</svg>"#,
        ),
        svg("an SVG of text", "<text>cat</text>"),
        svg(
            "a line that stays open",
            r#"<path d="M3.9 .5H.5V8.5H8.5V.5H5.25" fill="none" stroke="black" stroke-width=".2"/>"#,
        ),
        drawing("a picture cut off", "image/png", &png[..png.len() / 2]),
        drawing("no picture", "image/png", "not a picture"),
        drawing("a picture larger than it can be", "image/png", huge),
        drawing("a white picture", "image/png", encoded(GrayImage::from_pixel(64, 64, Luma([255])), ImageFormat::Png)),
        drawing("a picture of one pixel", "image/png", encoded(GrayImage::new(1, 1), ImageFormat::Png)),
        drawing("no JPEG", "image/jpeg", [0xff, 0xd8, 0xff, 0xe0, 0, 0]),
        Case { status: 415, place: Some("header content-type"), ..drawing("plain text", "text/plain", "a cat") },
        case(
            "vertices by the query",
            Method::POST,
            "/v1/sketches?target_vertices=7",
            422,
            Some("query parameter target_vertices"),
        )
        .carrying(SQUARE_SVG),
        case("a figure of an outline", Method::POST, "/v1/sketches?figure=1", 422, Some("query parameter figure"))
            .with("content-type", "application/json")
            .carrying(r#"{"outline": [[0,0],[1,0],[0,1]]}"#),
        case("two numbers of vertices", Method::POST, two_numbers, 422, Some("query parameter target_vertices"))
            .with("content-type", "application/json")
            .carrying(r#"{"outline": [[0,0],[1,0],[0,1]], "target_vertices": 70}"#),
        case("a figure too many", Method::POST, "/v1/sketches?figure=4", 422, Some("query parameter figure"))
            .carrying(SQUARE_SVG),
    ]
}

fn requests() -> Vec<Case> {
    let whole = |name, body: &str, place| {
        case(name, Method::POST, "/v1/matches", 422, Some(place))
            .with("content-type", "application/json")
            .carrying(body)
    };
    vec![
        whole("no mesh", r#"{"sketch": "{sketch}"}"#, "/mesh"),
        whole("an unknown mesh", r#"{"mesh": "mesh_0", "sketch": "{sketch}"}"#, "/mesh"),
        whole("an unknown sketch", r#"{"mesh": "{mesh}", "sketch": "sketch_0"}"#, "/sketch"),
        whole("a sketch for a mesh", r#"{"mesh": "{sketch}", "sketch": "{sketch}"}"#, "/mesh"),
        whole("a number for a mesh", r#"{"mesh": 7, "sketch": "{sketch}"}"#, "/mesh"),
        whole("a list", "[]", ""),
        request("an unknown preset", r#""preset": "best""#, "/preset"),
        request("an unknown part", r#""part": "half""#, "/part"),
        request("no eigenfunctions", r#""basis": {"k": 0}"#, "/basis/k"),
        request("the most eigenfunctions there can be", r#""basis": {"k": 18446744073709551615}"#, "/basis/k"),
        request(
            "a zoom to the most eigenfunctions there can be",
            r#""refinement": {"method": "zoomout", "k": 18446744073709551615}"#,
            "/refinement/k",
        ),
        request(
            "bands of next to no width",
            r#""descriptors": {"wks": {"variance": 5e-324}}"#,
            "/descriptors/wks/variance",
        ),
        request("more eigenfunctions than vertices", r#""basis": {"k": 400}"#, "/basis/k"),
        request("an unknown boundary", r#""basis": {"boundary": "robin"}"#, "/basis/boundary"),
        request("an unknown regulariser", r#""regulariser": {"type": "l3"}"#, "/regulariser/type"),
        request("a regulariser without a type", r#""regulariser": {"gamma": 1}"#, "/regulariser/type"),
        request("a negative gamma", r#""regulariser": {"type": "l1", "gamma": -1}"#, "/regulariser/gamma"),
        request("a gamma in words", r#""regulariser": {"type": "l1", "gamma": "much"}"#, "/regulariser/gamma"),
        request(
            "no iterations",
            r#""regulariser": {"type": "l1", "max_iterations": 0}"#,
            "/regulariser/max_iterations",
        ),
        request("a misspelt gamma", r#""regulariser": {"type": "l1", "gama": 1}"#, "/regulariser/gama"),
        request("a negative sparsity", r#""weights": {"method": "cosamp", "sparsity": -1}"#, "/weights/sparsity"),
        request("unknown weights", r#""weights": {"method": "all"}"#, "/weights/method"),
        request("an unknown conversion", r#""conversion": {"method": "guess"}"#, "/conversion/method"),
        request("too large a zoom", r#""refinement": {"method": "zoomout", "k": 100000}"#, "/refinement/k"),
        request(
            "a landmark off the drawing",
            r#""landmarks": [{"sketch": [1e4, 0], "mesh": 0}]"#,
            "/landmarks/0/sketch",
        ),
        request("an object as a list", r#""basis": [20, 20, "neumann"]"#, "/basis"),
        request("a landmark off the mesh", r#""landmarks": [{"sketch": [0, 0], "mesh": 99999}]"#, "/landmarks/0/mesh"),
        request("too few labels", r#""regions": {"method": "given", "sketch": [0], "mesh": [0]}"#, "/regions/sketch"),
        request(
            "a label out of range",
            r#""regions": {"method": "given", "sketch": [0], "mesh": [4294967296]}"#,
            "/regions/mesh",
        ),
        request(
            "three regions for a pair",
            r#""regions": {"method": "segmented", "sketch_regions": 2, "mesh_regions": 2, "pairs": [[0, 1, 1]]}"#,
            "/regions/pairs",
        ),
        request("no regions", r#""regions": {"method": "auto", "count": 0}"#, "/regions/count"),
        request("an unknown setting", r#""speed": 11"#, "/speed"),
        Case { status: 400, ..whole("an empty request", "", "body") },
        case("a request without a type", Method::POST, "/v1/matches", 415, Some("header content-type")).carrying("{}"),
    ]
}

fn calls() -> Vec<Case> {
    vec![
        get("an unknown path", "/v1/nothing", 404, None),
        get("an unknown page of the manual", "/docs/nothing.css", 404, None),
        get("an unknown mesh", "/v1/meshes/mesh_0", 404, None),
        get("an unknown mesh's triangles", "/v1/meshes/mesh_0/mesh", 404, None),
        get("a sketch among the meshes", "/v1/meshes/{sketch}", 404, None),
        get("an unknown sketch's spectrum", "/v1/sketches/sketch_0/spectrum", 404, None),
        get("bytes that are no text", "/v1/meshes/%ff", 404, None),
        get("an unknown match", "/v1/matches/7", 404, None),
        get("an unknown match's result", "/v1/matches/7/result", 404, None),
        get("an unknown match's events", "/v1/matches/7/events", 404, None),
        case("the end of an unknown match", Method::DELETE, "/v1/matches/7", 404, None),
        get("an unknown regulariser", "/v1/regularisers/l3", 404, None),
        case("a mesh put", Method::PUT, "/v1/meshes", 405, None),
        case("an unknown mesh deleted", Method::DELETE, "/v1/meshes/7", 404, None),
        case("a match patched", Method::PATCH, "/v1/matches/7", 405, None),
        get("a page of nothing", "/v1/meshes?limit=0", 422, Some("query parameter limit")),
        get("a page of many", "/v1/meshes?limit=few", 422, Some("query parameter limit")),
        get("a page after nothing", "/v1/matches?after=there", 422, Some("query parameter after")),
        get("a spectrum of nothing", "/v1/meshes/{mesh}/spectrum?k=0", 422, Some("query parameter k")),
        get("a spectrum without end", "/v1/meshes/{mesh}/spectrum?k=100000", 422, Some("query parameter k")),
        get("an unknown boundary", "/v1/meshes/{mesh}/spectrum?boundary=robin", 422, Some("query parameter boundary")),
        get("a spectrum as a picture", "/v1/meshes/{mesh}/spectrum", 406, Some("header accept"))
            .with("accept", "image/png"),
    ]
}

#[tokio::test(flavor = "multi_thread")]
async fn every_bad_input_is_refused_with_its_place_and_leaves_nothing() {
    // A mesh may have four times as many triangles as are matched.
    let config = Config { max_upload_bytes: 200_000, max_triangles: 600, ..Config::default() };
    let server = Server::idle(config).await;
    let (mesh, sketch) = (server.mesh().await, server.sketch().await);
    let lists = ["/v1/meshes", "/v1/sketches", "/v1/matches"];
    let mut before = Vec::new();
    for list in lists {
        before.push(server.read(list).await);
    }
    let groups = [meshes(), uploads(), outlines(), drawings(), requests(), calls()];
    let cases: Vec<Case> = groups.into_iter().flatten().collect();
    assert!(cases.len() >= 60);
    let mut wrong = Vec::new();
    for case in &cases {
        let answer = case.request(&server, &mesh, &sketch).send().await.unwrap();
        let (status, kind) = (answer.status().as_u16(), answer.headers().get("content-type").cloned());
        let text = answer.text().await.unwrap();
        let problem: Value = serde_json::from_str(&text).unwrap_or_default();
        if status != case.status
            || kind.is_none_or(|kind| kind != "application/problem+json")
            || !case.is_named_by(&problem)
        {
            wrong.push(format!("{}: {} {:?} wanted, got {text}", case.name, case.status, case.place));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    for (list, before) in lists.iter().zip(before) {
        assert_eq!(server.read(list).await, before);
    }
    assert_eq!(server.read("/healthz").await, json!({"status": "ok"}));
    problem_of(server.get("/v1/nothing").send().await.unwrap(), 404).await;
}
