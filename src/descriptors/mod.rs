//! Point descriptors made of eigenpairs.

pub mod global_point_signature;
