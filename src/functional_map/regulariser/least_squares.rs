//! ρ = 0: the data term alone, eq. 2.13.

use serde::{Deserialize, Serialize};

use super::{About, Formula, Found, Search, Term};
use crate::functional_map::problem::least_squares;

/// ρ = 0: least squares.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LeastSquares {}

pub(super) static ABOUT: About = About {
    r#type: "none",
    title: "Least squares",
    formula: Formula { text: "‖C A − B‖²_F", latex: r"\|CA - B\|_F^2" },
    equation: "2.13",
    solver: "exact: the solution of least norm",
    parameters: &[],
};

impl Term for LeastSquares {
    fn minimiser(&self, search: Search<'_>) -> Found {
        let c = least_squares(search.problem)?;
        Ok(search.directly(c, |c| search.problem.variable(c)))
    }
}
