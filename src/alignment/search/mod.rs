//! The views a sketch may be drawn from, and the poses a mesh may have in them.

pub mod candidates;
pub mod differences;
pub mod following;
pub mod pose;
