//! What is added to the data term ‖C A − B‖²_F, with its parameters.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::catalogue;

/// The regularisation term γ ρ(C) of the problem and how it is solved.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum Regulariser {
    /// ρ = 0: least squares, eq. 2.13.
    None {},
    /// ρ(C) = ‖W ⊙ C‖²_F, eq. 3.6.
    L2 {
        #[serde(default = "ten")]
        #[schema(minimum = 0, maximum = 1e9)]
        gamma: f64,
        #[serde(default = "two_hundred")]
        #[schema(minimum = 1, maximum = 20_000)]
        max_iterations: usize,
        #[serde(default)]
        #[schema(minimum = 0, maximum = 1)]
        tolerance: f64,
        #[serde(default)]
        solver: L2Solver,
    },
    /// ρ(C) = ‖W ⊙ C‖₁, eq. 3.22.
    L1 {
        #[serde(default = "one")]
        #[schema(minimum = 0, maximum = 1e9)]
        gamma: f64,
        #[serde(default = "two_hundred")]
        #[schema(minimum = 1, maximum = 20_000)]
        max_iterations: usize,
        #[serde(default)]
        #[schema(minimum = 0, maximum = 1)]
        tolerance: f64,
    },
    /// ρ(C) = ‖C‖_*, eq. 3.23.
    Nuclear {
        #[serde(default = "twenty")]
        #[schema(minimum = 0, maximum = 1e9)]
        gamma: f64,
        #[serde(default = "two_hundred")]
        #[schema(minimum = 1, maximum = 20_000)]
        max_iterations: usize,
        #[serde(default)]
        #[schema(minimum = 0, maximum = 1)]
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

/// What is wrong with the parameters of a regulariser: the name of each field at fault, and why.
pub fn faults(regulariser: &Regulariser) -> Vec<(&'static str, String)> {
    let (name, values) = match *regulariser {
        Regulariser::None {} => ("none", vec![]),
        Regulariser::L2 { gamma, max_iterations, tolerance, .. } => ("l2", numbers(gamma, max_iterations, tolerance)),
        Regulariser::L1 { gamma, max_iterations, tolerance } => ("l1", numbers(gamma, max_iterations, tolerance)),
        Regulariser::Nuclear { gamma, max_iterations, tolerance } => {
            ("nuclear", numbers(gamma, max_iterations, tolerance))
        }
    };
    let parameters = catalogue::parameters(name);
    values
        .into_iter()
        .filter_map(|(field, value)| {
            let parameter = parameters.iter().find(|parameter| parameter.name == field)?;
            Some((parameter.name, parameter.fault(value)?))
        })
        .collect()
}

fn numbers(gamma: f64, max_iterations: usize, tolerance: f64) -> Vec<(&'static str, f64)> {
    vec![("gamma", gamma), ("max_iterations", max_iterations as f64), ("tolerance", tolerance)]
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_out_of_range_are_all_named() {
        let regulariser = Regulariser::L1 { gamma: -1.0, max_iterations: 0, tolerance: f64::NAN };
        let fields: Vec<_> = faults(&regulariser).into_iter().map(|(field, _)| field).collect();
        assert_eq!(fields, ["gamma", "max_iterations", "tolerance"]);
        let regulariser =
            Regulariser::L2 { gamma: 2e9, max_iterations: 20_001, tolerance: 2.0, solver: L2Solver::Exact };
        assert_eq!(faults(&regulariser).len(), 3);
        assert_eq!(
            faults(&Regulariser::Nuclear { gamma: f64::INFINITY, max_iterations: 1, tolerance: 0.0 }),
            [("gamma", "inf is not between 0 and 1000000000".to_owned())]
        );
    }

    #[test]
    fn the_ends_of_the_ranges_are_allowed() {
        assert!(faults(&Regulariser::None {}).is_empty());
        assert!(faults(&Regulariser::L1 { gamma: 0.0, max_iterations: 1, tolerance: 0.0 }).is_empty());
        assert!(faults(&Regulariser::Nuclear { gamma: 1e9, max_iterations: 20_000, tolerance: 1.0 }).is_empty());
    }
}
