//! Solvers that know operators, not meshes.
//!
//! Dense matrices are `faer::Mat<f64>`, sparse operators `sprs::CsMat<f64>`. faer is built without threads and every
//! call that takes a parallelism runs with `Par::Seq`, so that results are the same bytes whatever the thread count.

pub mod block_lanczos;
pub mod cholesky;

mod report;
mod watch;

pub use report::{Report, Stopped};
pub use watch::{Cancelled, Unwatched, Watch};
