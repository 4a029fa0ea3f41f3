//! ρ = 0: the data term alone, eq. 2.13.

use faer::{Mat, MatRef};
use serde::{Deserialize, Serialize};

use super::{About, EXACT, EXACT_ITERATIONS, Formula, Term, step};
use crate::functional_map::MapError;
use crate::functional_map::problem::{Problem, least_squares};
use crate::numerics::conjugate_gradient::{self, Smooth};
use crate::numerics::{Report, Stopped, Stopping, Watch};

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
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn minimiser(
        &self,
        problem: &Problem,
        _weights: &Mat<f64>,
        start: Mat<f64>,
        watch: &dyn Watch,
    ) -> Result<(Mat<f64>, Report), MapError> {
        if !problem.is_of_rows() {
            let h = Smooth {
                objective: |c: MatRef<'_, f64>| problem.variable(c),
                gradient: |c: MatRef<'_, f64>| problem.gradient(c),
                step: step(problem.lipschitz()?),
            };
            let stopping = Stopping { max_iterations: EXACT_ITERATIONS, tolerance: EXACT };
            return Ok(conjugate_gradient::minimise(&h, start, stopping, watch)?);
        }
        let c = least_squares(problem)?;
        let history = vec![problem.variable(start.as_ref()), problem.variable(c.as_ref())];
        Ok((c, Report { iterations: 0, history, stopped: Stopped::Converged }))
    }
}
