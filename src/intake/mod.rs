//! What comes in, bytes and what is said of them, taken as a mesh, a sketch or a value, with all that is to be said of it
//! or against it.
//!
//! The service and the program take the same things and refuse them in the same words.

pub mod json;
pub mod mesh;
pub mod sketch;
pub mod svg_reader;
mod untaken;
mod warnings;

pub use untaken::{Cause, Fault, Untaken};
