//! ρ(C) = ‖W ⊙ C‖₁, eq. 3.22.

use faer::{MatRef, Scale};

use super::{About, Formula, Found, Search, Term, entries, iterated, step};
use crate::numerics::proximal_operators::soft_threshold;

iterated! {
    /// ρ(C) = ‖W ⊙ C‖₁.
    pub struct L1 {
        gamma = 1.0;
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
    /// Proximal gradients, thresholds λ γ W.
    fn minimiser(&self, search: Search<'_>) -> Found {
        let Search { problem, weights, .. } = search;
        let step = step(problem.lipschitz()?);
        let thresholds = Scale(step * self.gamma) * weights;
        let term = |c: MatRef<'_, f64>| self.gamma * entries(weights, c).map(|(w, c)| (w * c).abs()).sum::<f64>();
        let proximal = |v: MatRef<'_, f64>| {
            let c = soft_threshold(v, thresholds.as_ref());
            let term = term(c.as_ref());
            Ok((c, term))
        };
        search.by_proximal_gradients(|c| Ok(term(c)), proximal, step, self.stopping())
    }
}
