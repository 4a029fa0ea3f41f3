//! ρ(C) = ‖C‖_*, eq. 3.23.

use faer::{Mat, MatRef};

use super::{About, Formula, MAX_ITERATIONS, TOLERANCE, Term, gamma, step};
use crate::functional_map::MapError;
use crate::functional_map::parameter::parameters;
use crate::functional_map::problem::Problem;
use crate::numerics::proximal_gradient::{self, Composite};
use crate::numerics::proximal_operators::{nuclear_norm, singular_value_threshold};
use crate::numerics::{Report, Stopping, Watch};

parameters! {
    /// ρ(C) = ‖C‖_*.
    pub struct Nuclear {
        gamma: f64 = gamma(20.0),
        max_iterations: usize = MAX_ITERATIONS,
        tolerance: f64 = TOLERANCE,
    }
}

pub(super) static ABOUT: About = About {
    r#type: "nuclear",
    title: "Nuclear norm",
    formula: Formula { text: "‖C A − B‖²_F + γ ‖C‖_*", latex: r"\|CA - B\|_F^2 + \gamma \|C\|_*" },
    equation: "3.23",
    solver: "fast proximal gradient: soft thresholding of singular values",
    parameters: Nuclear::PARAMETERS,
};

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
