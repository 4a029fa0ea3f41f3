//! The service as its clients see it: every test starts a server of its own and speaks HTTP.

mod bad_inputs;
mod command_line;
mod connections;
mod crash;
mod damage;
mod determinism;
mod drawings;
mod examples;
mod front_page;
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
#[path = "../../src/store/database/testing/schema.rs"]
mod schema;
mod server;
mod spectra;
mod tenants;
mod uploads;
mod walk;
