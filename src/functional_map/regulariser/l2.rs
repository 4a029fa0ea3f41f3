//! ρ(C) = ‖W ⊙ C‖²_F, eq. 3.6.

use faer::{Mat, MatRef};
use serde::{Deserialize, Serialize};

use super::{About, EXACT, EXACT_ITERATIONS, Formula, Found, Search, Term, entries, iterated, step};
use crate::functional_map::parameter::{Declared, word};
use crate::functional_map::ridge;
use crate::numerics::conjugate_gradient::{self, Smooth};

iterated! {
    /// ρ(C) = ‖W ⊙ C‖²_F.
    pub struct L2 {
        gamma = 10.0;
        solver: L2Solver = SOLVER,
    }
}

/// How the ℓ2 problem is solved; both reach the same C.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum L2Solver {
    /// Row by row: (A Aᵀ + γ diag(w_i²)) c_i = A b_i.
    Exact,
    /// Conjugate gradients with backtracking, as in §3.4.
    ConjugateGradient,
}

const SOLVER: Declared<L2Solver> =
    word("both reach the same C; the exact one does not iterate", L2Solver::Exact, &["exact", "conjugate_gradient"]);

pub(super) static ABOUT: About = About {
    r#type: "l2",
    title: "Weighted squared entries",
    formula: Formula {
        text: "‖C A − B‖²_F + γ ‖W ⊙ C‖²_F", latex: r"\|CA - B\|_F^2 + \gamma \|W \odot C\|_F^2"
    },
    equation: "3.6",
    solver: "exact row by row where no terms are added, or conjugate gradients (Hestenes and Stiefel) with backtracking",
    parameters: L2::PARAMETERS,
};

impl Term for L2 {
    fn minimiser(&self, search: Search<'_>) -> Found {
        match self.solver {
            L2Solver::Exact if search.problem.is_of_rows() => self.exactly(search),
            L2Solver::Exact => {
                // Commutators tie the rows together; as far as descent can be judged this is exact too.
                let L2 { gamma, solver, .. } = *self;
                let to_the_end = L2 { gamma, solver, max_iterations: EXACT_ITERATIONS, tolerance: EXACT };
                to_the_end.by_conjugate_gradients(search)
            }
            L2Solver::ConjugateGradient => self.by_conjugate_gradients(search),
        }
    }
}

impl L2 {
    /// ‖C A − B‖²_F + γ ‖W ⊙ C‖²_F without the constant.
    fn objective(&self, search: &Search<'_>, c: MatRef<'_, f64>) -> f64 {
        let term: f64 = entries(search.weights, c).map(|(w, c)| (w * c).powi(2)).sum();
        search.problem.variable(c) + self.gamma * term
    }

    fn exactly(&self, search: Search<'_>) -> Found {
        let c = ridge::minimiser(search.problem, self.gamma, search.weights.as_ref(), search.watch)?;
        Ok(search.directly(c, |c| self.objective(&search, c)))
    }

    /// With the gradient of eq. 3.21: 2 C A Aᵀ − 2 B Aᵀ + 2 γ W ⊙ W ⊙ C.
    fn by_conjugate_gradients(&self, search: Search<'_>) -> Found {
        let Search { problem, weights, .. } = search;
        let curvature =
            Mat::from_fn(weights.nrows(), weights.ncols(), |i, j| 2.0 * self.gamma * weights[(i, j)].powi(2));
        let h = Smooth {
            objective: |c: MatRef<'_, f64>| Ok(self.objective(&search, c)),
            gradient: |c: MatRef<'_, f64>| {
                let data = problem.gradient(c);
                Ok(Mat::from_fn(c.nrows(), c.ncols(), |i, j| data[(i, j)] + curvature[(i, j)] * c[(i, j)]))
            },
            step: step(problem.lipschitz()? + curvature.norm_max()),
        };
        Ok(conjugate_gradient::minimise(&h, search.start.clone(), self.stopping(), search.watch)?)
    }
}
