//! Small drawings that ask for much: each is refused soon, in words, and the server lives on.

use std::fmt::Write;
use std::time::{Duration, Instant};

use sketchmatch::http::Config;

use crate::drawings::SQUARE_SVG;
use crate::server::{Server, json_of, problem_of};

/// How long a refusal may take on a busy machine, in a build for tests. Unbounded, they take minutes or gigabytes.
const SOON: Duration = Duration::from_secs(60);

/// A drawing of this inside, and a square.
fn svg(inside: &str) -> String {
    format!(
        r#"<svg xmlns="http://www.w3.org/2000/svg" xmlns:xlink="http://www.w3.org/1999/xlink" viewBox="0 0 100 100"><path id="p" d="M10 10h80v80h-80z"/>{inside}</svg>"#
    )
}

fn repeated(count: usize, one: impl Fn(usize) -> String) -> String {
    (0..count).fold(String::new(), |mut text, i| {
        // Writing to a string does not fail.
        let _ = write!(text, "{}", one(i));
        text
    })
}

/// Entities declared before a drawing of this inside.
fn with_entities(entities: &str, inside: &str) -> String {
    format!("<!DOCTYPE svg [{entities}]>{}", svg(inside))
}

/// Drawings by what they ask for too much of, with a word of the refusal.
fn bombs() -> Vec<(&'static str, String, &'static str)> {
    let long = "x".repeat(80_000);
    let entity = format!(r#"<!ENTITY e "{long}">"#);
    let hidden = format!(r#"<!ENTITY a "<!ENTITY {long}">"#);
    let twice = format!(r#"<!-- <!ENTITY e ""> --><!ENTITY e '{long}'>"#);
    let nested = repeated(9, |i| format!(r#"<!ENTITY e{} "{}">"#, i + 1, format!("&e{i};").repeat(25)));
    let elements = |count: usize| repeated(count, |i| format!(r#"<rect class="c{i}"/>"#));
    let rules = |count: usize| repeated(count, |i| format!(".c{i}{{fill:red}}"));
    let styled = |rules: &str, inside: &str| svg(&format!("<style>{rules}</style>{inside}"));
    let zigzag = |strokes: usize| format!("M0 0{}", "l1 1 1-1".repeat(strokes));
    let doubling =
        repeated(24, |i| format!(r##"<g id="g{}"><use xlink:href="#g{i}"/><use xlink:href="#g{i}"/></g>"##, i + 1));
    vec![
        ("an entity in the text, often", with_entities(&entity, &"&e;".repeat(20_000)), "entities"),
        ("an entity in attributes, often", with_entities(&entity, &r#"<g class="&e;"/>"#.repeat(20_000)), "entities"),
        (
            "an entity declared within another",
            with_entities(&hidden, &r#"<g class="&a;"/>"#.repeat(20_000)),
            "entities",
        ),
        ("an entity declared twice", with_entities(&twice, &r#"<g class="&e;"/>"#.repeat(20_000)), "entities"),
        (
            "entities of entities",
            with_entities(&format!(r#"<!ENTITY e0 "{}">{nested}"#, "x".repeat(99)), &"&e2;&e9;".repeat(9_000)),
            "entities",
        ),
        (
            "many entities",
            with_entities(&repeated(20_000, |i| format!(r#"<!ENTITY e{i} "">"#)), &"&e19999;".repeat(20_000)),
            "entities",
        ),
        ("many attributes", svg(&format!("<g {}/>", repeated(200_000, |i| format!(r#"a{i}="" "#)))), "attributes"),
        (
            "many namespaces",
            svg(&format!("<g {}/>", repeated(200_000, |i| format!(r#"xmlns:n{i}="{i}" "#)))),
            "attributes",
        ),
        ("a namespace for every element", svg(&repeated(60_000, |i| format!(r#"<g xmlns:n{i}="{i}">"#))), "namespaces"),
        ("many rules for many elements", styled(&rules(20_000), &elements(20_000)), "style sheet"),
        ("very many rules", styled(&rules(150_000), &elements(4_000)), "style sheet"),
        (
            "rules of many ancestors",
            styled(
                &format!("{} x{{fill:red}}", "g ".repeat(12)),
                &format!("{}{}", "<g>".repeat(60), "</g>".repeat(60)),
            ),
            "style sheet",
        ),
        (
            "selectors with many declarations",
            styled(&format!("{}a{{{}}}", "a,".repeat(9_000), "x:y;".repeat(9_000)), ""),
            "style sheet",
        ),
        ("rules that are all wrong", styled(&"a{b;}".repeat(200_000), ""), "style sheet"),
        ("many style sheets", svg(&"<style>a{b:c}</style>".repeat(30_000)), "style sheet"),
        (
            "a long rule for many elements",
            styled(&format!("*{{font-family:{long}}}"), &elements(20_000)),
            "style sheet",
        ),
        (
            "a long style that many inherit",
            svg(&format!(r#"<g font-family="{long}">{}</g>"#, elements(20_000))),
            "style",
        ),
        (
            "a long row of dashes that many inherit",
            svg(&format!(r#"<g stroke-dasharray="{}">{}</g>"#, "1 ".repeat(60_000), elements(20_000))),
            "style",
        ),
        ("uses of uses", svg(&format!(r##"<g id="g0"><rect/></g>{doubling}<use xlink:href="#g24"/>"##)), "elements"),
        (
            "a long path used often",
            svg(&format!(
                r##"<defs><path id="z" d="{}"/></defs>{}"##,
                zigzag(100_000),
                r##"<use xlink:href="#z"/>"##.repeat(100)
            )),
            "paths",
        ),
        (
            "a very long path",
            svg(&format!(r#"<path stroke="red" stroke-width="9" d="{}"/>"#, zigzag(1_500_000))),
            "paths",
        ),
        ("deep nesting", svg(&format!("{}{}", "<g>".repeat(100_000), "</g>".repeat(100_000))), "nested"),
        ("a viewBox far away", svg("").replace("0 0 100 100", "1e308 0 100 100"), "viewBox"),
        ("a viewBox of next to nothing", svg("").replace("0 0 100 100", "0 0 1e-300 1e-300"), "viewBox"),
        ("a viewBox beyond single precision", svg("").replace("0 0 100 100", "0 0 1e39 1e39"), "viewBox"),
        (
            "a marker at every corner of a long path",
            svg(&format!(
                r##"<marker id="m">{}</marker><path marker-mid="url(#m)" d="{}"/>"##,
                "<path d='M0 0h1v1'/>".repeat(2_000),
                zigzag(100_000)
            )),
            "to read",
        ),
        (
            "a gradient of many equal stops",
            svg(&format!(
                r##"<linearGradient id="l">{}</linearGradient><rect width="9" height="9" fill="url(#l)"/>"##,
                r#"<stop offset=".5"/>"#.repeat(450_000)
            )),
            "",
        ),
    ]
}

#[tokio::test(flavor = "multi_thread")]
async fn an_svg_that_asks_for_much_is_refused_soon() {
    let program = Some(env!("CARGO_BIN_EXE_sketchmatch").into());
    let server = Server::idle(Config { svg_reader: program, ..Config::default() }).await;
    let upload = |text: String| server.post("/v1/sketches").header("content-type", "image/svg+xml").body(text).send();
    for (name, text, word) in bombs() {
        let started = Instant::now();
        let bytes = text.len();
        let answer = upload(text).await.unwrap();
        println!("{name}: {bytes} bytes, {:.2} s", started.elapsed().as_secs_f64());
        assert!(started.elapsed() < SOON, "{name} took {:?}", started.elapsed());
        if !word.is_empty() {
            let problem = problem_of(answer, 422).await;
            assert!(problem["errors"][0]["detail"].as_str().unwrap().contains(word), "{name}: {problem}");
        }
    }
    json_of(upload(SQUARE_SVG.to_owned()).await.unwrap(), 201).await;
}

#[tokio::test(flavor = "multi_thread")]
async fn an_svg_is_the_same_sketch_wherever_it_is_read() {
    let mut vertices = Vec::new();
    for program in [None, Some(env!("CARGO_BIN_EXE_sketchmatch").into())] {
        let server = Server::idle(Config { svg_reader: program, ..Config::default() }).await;
        let upload = server.post("/v1/sketches").header("content-type", "image/svg+xml").body(SQUARE_SVG);
        let sketch = json_of(upload.send().await.unwrap(), 201).await;
        vertices.push(server.read(&format!("/v1/sketches/{}/mesh", sketch["id"].as_str().unwrap())).await);
    }
    assert_eq!(vertices[0], vertices[1]);
}

#[tokio::test(flavor = "multi_thread")]
async fn json_of_the_wrong_shape_is_refused_soon() {
    let server = Server::idle(Config::default()).await;
    let members = |count: usize| repeated(count, |i| format!(r#""{i}": 0, "#)).trim_end_matches(", ").to_owned();
    let points = "[0,0],".repeat(2_000_000);
    for (name, text, status, pointer) in [
        ("an object for a line", format!(r#"{{"outline": {{{}}}}}"#, members(20_000)), 422, "/outline"),
        ("an object for a point", format!(r#"{{"outline": [{{{}}}]}}"#, members(20_000)), 422, "/outline/0"),
        ("unknown members", format!("{{{}}}", members(900_000)), 422, "/0"),
        ("a wrong point after many", format!(r#"{{"outline": [{points}[0]]}}"#), 422, "/outline/2000000"),
        (
            "a text for vertices",
            r#"{"outline": [[0,0],[1,0],[0,1]], "target_vertices": "many"}"#.into(),
            422,
            "/target_vertices",
        ),
    ] {
        let started = Instant::now();
        let answer = server.post("/v1/sketches").header("content-type", "application/json").body(text).send();
        let problem = problem_of(answer.await.unwrap(), status).await;
        assert_eq!(problem["errors"][0]["pointer"], pointer, "{name}: {problem}");
        assert!(started.elapsed() < SOON, "{name} took {:?}", started.elapsed());
    }
    let request = format!(r#"{{"mesh": "m", "sketch": "s", "regions": {{"method": 7, {}}}}}"#, members(200_000));
    let started = Instant::now();
    let answer = server.post("/v1/matches").header("content-type", "application/json").body(request).send();
    problem_of(answer.await.unwrap(), 422).await;
    assert!(started.elapsed() < SOON, "{:?}", started.elapsed());
    let long = format!(r#"{{"outline": [{}]}}"#, "[0,0],".repeat(3_000_000));
    let answer = server.post("/v1/sketches").body(long).send();
    problem_of(answer.await.unwrap(), 413).await;
}
