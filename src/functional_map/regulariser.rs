//! What is added to the data term ‖C A − B‖²_F, with its parameters.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// The regularisation term γ ρ(C) of the problem and how it is solved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum Regulariser {
    /// ρ = 0: least squares, eq. 2.13.
    None {},
    /// ρ(C) = ‖W ⊙ C‖²_F, eq. 3.6.
    L2 {
        #[serde(default = "ten")]
        gamma: f64,
        #[serde(default = "two_hundred")]
        max_iterations: usize,
        #[serde(default)]
        tolerance: f64,
        #[serde(default)]
        solver: L2Solver,
    },
    /// ρ(C) = ‖W ⊙ C‖₁, eq. 3.22.
    L1 {
        #[serde(default = "one")]
        gamma: f64,
        #[serde(default = "two_hundred")]
        max_iterations: usize,
        #[serde(default)]
        tolerance: f64,
    },
    /// ρ(C) = ‖C‖_*, eq. 3.23.
    Nuclear {
        #[serde(default = "twenty")]
        gamma: f64,
        #[serde(default = "two_hundred")]
        max_iterations: usize,
        #[serde(default)]
        tolerance: f64,
    },
}

/// How the ℓ2 problem is solved; both reach the same C.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum L2Solver {
    /// Row by row: (A Aᵀ + γ diag(w_i²)) c_i = A b_i.
    #[default]
    Exact,
    /// Conjugate gradients with backtracking, as in §3.4.
    ConjugateGradient,
}

fn one() -> f64 {
    1.0
}

fn ten() -> f64 {
    10.0
}

fn twenty() -> f64 {
    20.0
}

fn two_hundred() -> usize {
    200
}
