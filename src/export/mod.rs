//! What is stored, written out in the forms people and programs take: tables, arrays, pictures, coloured meshes.
//!
//! The service and the program write the same files.

pub mod correspondences;
pub mod evaluation;
pub mod functional_map;
pub mod functions;
pub mod geometry;
pub mod inside;
mod npy;
pub mod picture;
pub mod pose;
pub mod spectrum;
pub mod transfer;
mod unwritten;

pub use unwritten::Unwritten;
