//! ρ(C) = ‖W ⊙ C‖₁, eq. 3.22.

use faer::{Mat, MatRef, Scale};

use super::{About, Formula, MAX_ITERATIONS, TOLERANCE, Term, entries, gamma, step};
use crate::functional_map::MapError;
use crate::functional_map::parameter::parameters;
use crate::functional_map::problem::Problem;
use crate::numerics::proximal_gradient::{self, Composite};
use crate::numerics::proximal_operators::soft_threshold;
use crate::numerics::{Report, Stopping, Watch};

parameters! {
    /// ρ(C) = ‖W ⊙ C‖₁.
    pub struct L1 {
        gamma: f64 = gamma(1.0),
        max_iterations: usize = MAX_ITERATIONS,
        tolerance: f64 = TOLERANCE,
    }
}

pub(super) static ABOUT: About = About {
    r#type: "l1",
    title: "Weighted absolute entries",
    formula: Formula {
        text: "‖C A − B‖²_F + γ ‖W ⊙ C‖₁", latex: r"\|CA - B\|_F^2 + \gamma \|W \odot C\|_1"
    },
    equation: "3.22",
    solver: "fast proximal gradient: soft thresholding of entries",
    parameters: L1::PARAMETERS,
};

impl Term for L1 {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    /// The fast gradient method, thresholds λ γ W.
    fn minimiser(
        &self,
        problem: &Problem,
        weights: &Mat<f64>,
        start: Mat<f64>,
        watch: &dyn Watch,
    ) -> Result<(Mat<f64>, Report), MapError> {
        let L1 { gamma, max_iterations, tolerance } = *self;
        let step = step(problem.lipschitz()?);
        let thresholds = Scale(step * gamma) * weights;
        let term = |c: MatRef<'_, f64>| gamma * entries(weights, c).map(|(w, c)| (w * c).abs()).sum::<f64>();
        let h = Composite {
            smooth: |c: MatRef<'_, f64>| problem.variable(c),
            term: |c: MatRef<'_, f64>| Ok(term(c)),
            gradient: |c: MatRef<'_, f64>| problem.gradient(c),
            proximal: |v: MatRef<'_, f64>| {
                let c = soft_threshold(v, thresholds.as_ref());
                let term = term(c.as_ref());
                Ok((c, term))
            },
            step,
        };
        proximal_gradient::minimise(&h, start, Stopping { max_iterations, tolerance }, watch)
    }
}
