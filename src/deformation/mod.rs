//! Shapes led to other places and bent as little as may be.

pub mod as_rigid_as_possible;
