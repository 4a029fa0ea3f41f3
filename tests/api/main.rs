//! The service as its clients see it: every test starts a server of its own and speaks HTTP.

mod bad_inputs;
mod crash;
mod determinism;
mod drawings;
mod headers;
mod openapi;
mod pictures;
mod program;
mod server;
mod spectra;
mod uploads;
mod walk;
