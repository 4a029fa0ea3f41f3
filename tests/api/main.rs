//! The service as its clients see it: every test starts a server of its own and speaks HTTP.

mod bad_inputs;
mod bucket;
mod client;
mod command_line;
mod connections;
mod crash;
mod damage;
mod determinism;
mod drawings;
mod evaluations;
mod examples;
mod front_page;
mod full_disk;
mod functions;
mod hang_ups;
mod headers;
mod hostile_drawings;
mod keys;
mod logs;
mod nodes;
mod openapi;
mod pictures;
mod poses;
mod program;
mod queue;
mod researchers;
#[path = "../../src/store/database/testing/schema.rs"]
mod schema;
mod scripts;
mod server;
mod spectra;
mod tenants;
mod transfers;
mod uploads;
mod walk;
