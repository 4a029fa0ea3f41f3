//! ρ(C) = ‖W ⊙ C‖₁ where the order of the regions is not known [PBB+13], eq. 2.14.

use faer::Mat;

use super::{About, Formula, L1, MAX_ITERATIONS, TOLERANCE, Term, gamma};
use crate::functional_map::MapError;
use crate::functional_map::parameter::{Declared, integer, parameters};
use crate::functional_map::problem::Problem;
use crate::numerics::{Report, Watch};

const ROUNDS: Declared<usize> = integer("times that C and the order are found in turns at most", 20, 1, 1000);

parameters! {
    /// ρ(C) = ‖W ⊙ C‖₁, C and the permutation of the regions together.
    pub struct PermutedL1 {
        gamma: f64 = gamma(1.0),
        rounds: usize = ROUNDS,
        max_iterations: usize = MAX_ITERATIONS,
        tolerance: f64 = TOLERANCE,
    }
}

pub(super) static ABOUT: About = About {
    r#type: "permuted_l1",
    title: "Weighted absolute entries, the order of the regions unknown",
    formula: Formula {
        text: "‖C A − B Π‖²_F + γ ‖W ⊙ C‖₁, Π a permutation of the regions",
        latex: r"\|CA - B\Pi\|_F^2 + \gamma \|W \odot C\|_1, \; \Pi \text{ a permutation of the regions}",
    },
    equation: "2.14",
    solver: "in turns C as l1 and Π by assignment of least cost, from the pairs of the request and from the plain diagonal; \
             the better of both",
    parameters: PermutedL1::PARAMETERS,
};

impl PermutedL1 {
    /// The problem in C alone.
    fn in_order(&self) -> L1 {
        L1 { gamma: self.gamma, max_iterations: self.max_iterations, tolerance: self.tolerance }
    }
}

impl Term for PermutedL1 {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    /// C for the order that `problem` has the regions in; [`permutation`](crate::functional_map::permutation) finds the order.
    fn minimiser(
        &self,
        problem: &Problem,
        weights: &Mat<f64>,
        start: Mat<f64>,
        watch: &dyn Watch,
    ) -> Result<(Mat<f64>, Report), MapError> {
        self.in_order().minimiser(problem, weights, start, watch)
    }
}
