//! The automatic part: a sketch laid on a mesh by the view it is drawn from, with nobody clicking.
//!
//! Both shapes are scaled to area 1, so that every length is in units of the square root of the shape's own area unless
//! it says pixels.

pub mod frame;
pub mod limbs;
mod mirror;
pub mod sampled_distances;
pub mod symmetry;
pub mod views;

#[cfg(test)]
mod solids;
