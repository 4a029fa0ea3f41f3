//! ρ(C) = ‖C‖_*, eq. 3.23.

use faer::{Mat, MatRef};
use serde::{Deserialize, Serialize};

use super::{About, Formula, MAX_ITERATIONS, TOLERANCE, Term, gamma, step};
use crate::functional_map::MapError;
use crate::functional_map::parameter::Declared;
use crate::functional_map::problem::Problem;
use crate::numerics::proximal_gradient::{self, Composite};
use crate::numerics::proximal_operators::{nuclear_norm, singular_value_threshold};
use crate::numerics::{Report, Stopping, Watch};

/// ρ(C) = ‖C‖_*.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Nuclear {
    pub gamma: f64,
    pub max_iterations: usize,
    pub tolerance: f64,
}

const GAMMA: Declared<f64> = gamma(20.0);

pub(super) static ABOUT: About = About {
    r#type: "nuclear",
    title: "Nuclear norm",
    formula: Formula { text: "‖C A − B‖²_F + γ ‖C‖_*", latex: r"\|CA - B\|_F^2 + \gamma \|C\|_*" },
    equation: "3.23",
    solver: "fast proximal gradient: soft thresholding of singular values",
    parameters: &[GAMMA.named("gamma"), MAX_ITERATIONS.named("max_iterations"), TOLERANCE.named("tolerance")],
};

impl Default for Nuclear {
    fn default() -> Nuclear {
        Nuclear { gamma: GAMMA.default, max_iterations: MAX_ITERATIONS.default, tolerance: TOLERANCE.default }
    }
}

impl Term for Nuclear {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    /// The fast gradient method, threshold λ γ.
    fn minimiser(
        &self,
        problem: &Problem,
        _weights: &Mat<f64>,
        start: Mat<f64>,
        watch: &dyn Watch,
    ) -> Result<(Mat<f64>, Report), MapError> {
        let Nuclear { gamma, max_iterations, tolerance } = *self;
        let step = step(problem.lipschitz()?);
        let h = Composite {
            smooth: |c: MatRef<'_, f64>| problem.variable(c),
            term: |c: MatRef<'_, f64>| Ok(gamma * nuclear_norm(c)?),
            gradient: |c: MatRef<'_, f64>| problem.gradient(c),
            proximal: |v: MatRef<'_, f64>| {
                let (c, norm) = singular_value_threshold(v, step * gamma)?;
                Ok((c, gamma * norm))
            },
            step,
        };
        proximal_gradient::minimise(&h, start, Stopping { max_iterations, tolerance }, watch)
    }
}
