//! Solvers that know operators, not meshes.
//!
//! Dense matrices are `faer::Mat<f64>`, sparse operators `sprs::CsMat<f64>`. faer is built without threads and every
//! call that takes a parallelism runs with `Par::Seq`, so that results are the same bytes whatever the thread count.

pub mod block_lanczos;
pub mod bounded_quadratic;
pub mod cholesky;
pub mod conjugate_gradient;
pub mod cosamp;
pub mod distance_transform;
pub mod least_squares;
pub mod nelder_mead;
pub mod patched_rows;
pub mod proximal_gradient;
pub mod proximal_operators;
pub mod row_search;

mod krylov_space;
pub(crate) mod lanes;
mod oriented_boxes;
mod tall_block;
mod triangular_solve;

mod apart;
mod decomposition_error;
mod frobenius;
mod instruction_set;
mod median;
mod report;
mod side_by_side;
mod stopping;
pub(crate) mod watch;

#[cfg(test)]
pub(crate) mod random;

pub use apart::apart;
pub use decomposition_error::DecompositionError;
pub use frobenius::inner_product;
pub use instruction_set::instruction_set;
pub use median::median;
pub use report::{Report, Stopped};
pub use side_by_side::side_by_side;
pub use stopping::Stopping;
pub use watch::{Cancelled, Pace, STRIDE, Share, Unwatched, Watch};
