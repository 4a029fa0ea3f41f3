//! Shapes led to other places and bent as little as may be, and drawings moved by handles, whose bending goes over to a
//! surface.

pub mod as_rigid_as_possible;
pub mod biharmonic_weights;
mod domain;
pub mod handles;
mod links;
pub mod similarity;
pub mod strain;
pub mod transfer;

pub use links::joined;
