//! ρ(C) = ‖C‖_*, eq. 3.23.

use faer::MatRef;

use super::{About, Formula, Found, Search, Term, iterated, step};
use crate::numerics::proximal_operators::{nuclear_norm, singular_value_threshold};

iterated! {
    /// ρ(C) = ‖C‖_*.
    pub struct Nuclear {
        gamma = 20.0;
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
    /// Proximal gradients, threshold λ γ.
    fn minimiser(&self, search: Search<'_>) -> Found {
        let step = step(search.problem.lipschitz()?);
        let proximal = |v: MatRef<'_, f64>| {
            let (c, norm) = singular_value_threshold(v, step * self.gamma)?;
            Ok((c, self.gamma * norm))
        };
        search.by_proximal_gradients(|c| Ok(self.gamma * nuclear_norm(c)?), proximal, step, self.stopping())
    }
}
