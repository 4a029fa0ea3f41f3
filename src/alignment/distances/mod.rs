//! Geodesic distances as witnesses: how much a map bends them, and the map that bends them least.

pub mod by_distances;
pub mod distortion;
