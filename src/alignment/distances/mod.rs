//! Geodesic distances as witnesses: how much a map bends them, the map that bends them least, and one moved as landmarks say.

pub mod by_distances;
pub mod distortion;
pub mod kriging;
