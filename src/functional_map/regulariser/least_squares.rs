//! ρ = 0: the data term alone, eq. 2.13.

use faer::MatRef;
use serde::{Deserialize, Serialize};

use super::{About, EXACT, EXACT_ITERATIONS, Formula, Found, Search, Term, step};
use crate::functional_map::problem::least_squares;
use crate::numerics::Stopping;
use crate::numerics::conjugate_gradient::{self, Smooth};

/// ρ = 0: least squares.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LeastSquares {}

pub(super) static ABOUT: About = About {
    r#type: "none",
    title: "Least squares",
    formula: Formula { text: "‖C A − B‖²_F", latex: r"\|CA - B\|_F^2" },
    equation: "2.13",
    solver: "exact: the solution of least norm; with added terms conjugate gradients",
    parameters: &[],
};

impl Term for LeastSquares {
    fn minimiser(&self, search: Search<'_>) -> Found {
        if !search.problem.is_of_rows() {
            let problem = search.problem;
            let h = Smooth {
                objective: |c: MatRef<'_, f64>| Ok(problem.variable(c)),
                gradient: |c: MatRef<'_, f64>| Ok(problem.gradient(c)),
                step: step(problem.lipschitz()?),
            };
            let stopping = Stopping { max_iterations: EXACT_ITERATIONS, tolerance: EXACT };
            return Ok(conjugate_gradient::minimise(&h, search.start, stopping, search.watch)?);
        }
        let c = least_squares(search.problem)?;
        Ok(search.directly(c, |c| search.problem.variable(c)))
    }
}
