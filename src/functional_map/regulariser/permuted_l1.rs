//! ρ(C) = ‖W ⊙ C‖₁ where the order of the regions is not known [PBB+13], eq. 2.14.

use super::{About, Formula, Found, L1, Search, Term, iterated};
use crate::functional_map::parameter::{Declared, integer};

const ROUNDS: Declared<usize> = integer("times that C and the order are found in turns at most", 20, 1, 1000);

iterated! {
    /// ρ(C) = ‖W ⊙ C‖₁, C and the permutation of the regions together.
    pub struct PermutedL1 {
        gamma = 1.0;
        rounds: usize = ROUNDS,
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

impl Term for PermutedL1 {
    /// C for the order that the problem has the regions in; [`permutation`](crate::functional_map::permutation) finds the order.
    fn minimiser(&self, search: Search<'_>) -> Found {
        let PermutedL1 { gamma, .. } = *self;
        let stopping = self.stopping();
        let in_order = L1 { gamma, max_iterations: stopping.max_iterations, tolerance: stopping.tolerance };
        in_order.minimiser(search)
    }
}
