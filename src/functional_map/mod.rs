//! The energy of a functional map and its minimiser.
//!
//! Letters are the thesis's: the sketch M has the basis Φ (m × k), the mesh N the basis Ψ (n × l), C (l × k) takes
//! coefficients on M to coefficients on N, and A (k × q), B (l × q) hold q corresponding functions.

pub mod catalogue;
pub mod coupling;
pub mod parameter;
pub mod part;
pub mod permutation;
pub mod problem;
pub mod regulariser;
pub mod solve;
pub mod surface;
pub mod term;
pub mod weights;

mod diagonal;
mod error;
mod ridge;

pub use error::MapError;
