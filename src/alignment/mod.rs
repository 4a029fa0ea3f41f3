//! The automatic part: a sketch laid on a mesh by the view it is drawn from, with nobody clicking.
//!
//! Both shapes are scaled to area 1, so that every length is in units of the square root of the shape's own area unless
//! it says pixels.

pub mod contour;
pub mod frame;
mod inner_paths;
mod pieces;
mod shape_context;
pub mod silhouette;
pub mod single_outline;
pub mod warping;
