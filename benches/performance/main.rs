//! `make bench`: one table of what every stage costs, beside what the peer takes on the same files.
//!
//! `--sixty` counts warm matches for a minute, `--vast` adds 400K vertices to the growth, `--shapes` only writes the
//! files the peer is timed on, `--stretches` measures alone how long a job computes without asking whether to go on.

mod growth;
mod known;
mod pen;
mod posing;
mod server;
mod shapes;
mod stages;
mod stretches;
mod table;

use std::{env, fs};

fn main() {
    let arguments: Vec<String> = env::args().skip(1).collect();
    if let [flag, stage, size] = &arguments[..]
        && flag == growth::CHILD
    {
        return growth::child(stage, size.parse().expect("a size is a number"));
    }
    let asked = |flag: &str| arguments.iter().any(|argument| argument == flag);
    if asked("--shapes") {
        shapes::body(shapes::LARGE);
        shapes::drawn();
        return;
    }
    let peer = fs::read_to_string(shapes::directory().join("peer.json")).ok();
    let table = table::Table::begin(peer.and_then(|text| serde_json::from_str(&text).ok()).unwrap_or_default());
    if asked("--stretches") {
        return stretches::rows(&table);
    }
    stages::rows(&table);
    stretches::rows(&table);
    growth::of_drawings(&table);
    growth::rows(&table, asked("--vast"));
    server::rows(&table, if asked("--sixty") { 60.0 } else { 10.0 });
}
