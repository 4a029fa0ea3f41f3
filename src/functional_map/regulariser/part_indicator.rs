//! Partial functional maps [RCB+17]: C and which part of the mesh the sketch shows, together.

use faer::{Mat, MatRef};

use super::{About, Formula, Found, Search, Term, entries, iterated, step};
use crate::functional_map::parameter::{Declared, integer, number};
use crate::functional_map::ridge;
use crate::numerics::conjugate_gradient::{self, Smooth};

const ORTHOGONALITY: Declared<f64> =
    number("weight of CᵀC being the identity on the eigenvalues both have", 0.0, 0.0, 1e9);
const AREA: Declared<f64> = number("share of the mesh's area that the sketch shows", 0.5, 0.01, 1.0);
const AREA_WEIGHT: Declared<f64> = number("weight of the part having that area", 100.0, 0.0, 1e9);
const BOUNDARY_WEIGHT: Declared<f64> = number("weight of the length of the part's boundary", 100.0, 0.0, 1e9);
const ROUNDS: Declared<usize> = integer("times that C and the part are found in turns", 1, 1, 100);

iterated! {
    /// ρ(C) = ‖W ⊙ C‖²_F, C and an indicator of the part of the mesh that is shown together.
    pub struct PartIndicator {
        gamma = 1.0;
        orthogonality: f64 = ORTHOGONALITY,
        area: f64 = AREA,
        area_weight: f64 = AREA_WEIGHT,
        boundary_weight: f64 = BOUNDARY_WEIGHT,
        rounds: usize = ROUNDS,
    }
}

pub(super) static ABOUT: About = About {
    r#type: "part_indicator",
    title: "Partial functional map: weighted squared entries, the part of the mesh unknown",
    formula: Formula {
        text: "‖C A − B(η)‖²_F + γ ‖W ⊙ C‖²_F + μ ‖CᵀC − 1‖²_F + μ₁ (α − ∫ η)² + μ₂ ∫ ‖∇η‖, η the indicator of a part of the mesh",
        latex: r"\|CA - B(\eta)\|_F^2 + \gamma \|W \odot C\|_F^2 + \mu \|C^T C - 1\|_F^2 + \mu_1 \left(\alpha - \int \eta\right)^2 + \mu_2 \int \|\nabla \eta\|",
    },
    equation: "",
    solver: "in turns C, exact row by row as l2 where orthogonality weighs nothing, else by conjugate gradients, and η by \
             conjugate gradients, from the whole mesh",
    parameters: PartIndicator::PARAMETERS,
};

impl Term for PartIndicator {
    /// C for the part that the problem has; [`part`](crate::functional_map::part) finds the part.
    fn minimiser(&self, search: Search<'_>) -> Found {
        if self.orthogonality == 0.0 && search.problem.is_of_rows() {
            let c = ridge::minimiser(search.problem, self.gamma, search.weights.as_ref(), search.watch)?;
            return Ok(search.directly(c, |c| self.objective(&search, c)));
        }
        let Search { problem, weights, .. } = search;
        let largest = weights.norm_max();
        let h = Smooth {
            objective: |c: MatRef<'_, f64>| Ok(self.objective(&search, c)),
            gradient: |c: MatRef<'_, f64>| {
                let (data, beside) = (problem.gradient(c), c * self.unlike_identity(c));
                Ok(Mat::from_fn(c.nrows(), c.ncols(), |i, j| {
                    let weighted = 2.0 * self.gamma * weights[(i, j)].powi(2) * c[(i, j)];
                    data[(i, j)] + weighted + 4.0 * self.orthogonality * beside[(i, j)]
                }))
            },
            // That of the terms that are quadratic, and of orthogonality about a C whose singular values are 1.
            step: step(problem.lipschitz()? + 2.0 * self.gamma * largest * largest + 8.0 * self.orthogonality),
        };
        Ok(conjugate_gradient::minimise(&h, search.start.clone(), self.stopping(), search.watch)?)
    }
}

impl PartIndicator {
    fn objective(&self, search: &Search<'_>, c: MatRef<'_, f64>) -> f64 {
        let weighted: f64 = entries(search.weights, c).map(|(w, c)| (w * c).powi(2)).sum();
        let unlike = self.unlike_identity(c).squared_norm_l2();
        search.problem.variable(c) + self.gamma * weighted + self.orthogonality * unlike
    }

    /// CᵀC − 1, the 1 left out beyond the rows that C has.
    fn unlike_identity(&self, c: MatRef<'_, f64>) -> Mat<f64> {
        let mut product = c.transpose() * c;
        (0..c.ncols().min(c.nrows())).for_each(|i| product[(i, i)] -= 1.0);
        product
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::functional_map::problem::{Problem, least_squares};
    use crate::functional_map::regulariser::L2;
    use crate::numerics::{Unwatched, random};

    fn minimiser(term: &dyn Term, problem: &Problem) -> Mat<f64> {
        let weights = Mat::from_fn(problem.rows(), problem.columns(), |i, j| i.abs_diff(j) as f64);
        let start = least_squares(problem).unwrap();
        term.minimiser(Search { problem, weights: &weights, start, watch: &Unwatched }).unwrap().0
    }

    fn problem() -> Problem {
        let a = random::ill_conditioned(7, 60, 5.0, 1);
        let b = random::normal(9, 7, 2) * &a + 0.1 * random::normal(9, 60, 3);
        Problem::new(a.as_ref(), b.as_ref()).unwrap()
    }

    #[test]
    fn of_a_known_part_it_is_l2() {
        let wanted = minimiser(&L2 { gamma: 3.0, ..L2::default() }, &problem());
        let found = minimiser(&PartIndicator { gamma: 3.0, ..PartIndicator::default() }, &problem());
        assert!((found - wanted).norm_max() < 1e-12);
    }

    #[test]
    fn the_heavier_orthogonality_the_more_orthogonal_is_c() {
        let unlike = |orthogonality: f64| {
            let term = PartIndicator { orthogonality, gamma: 0.0, max_iterations: 2_000, ..PartIndicator::default() };
            term.unlike_identity(minimiser(&term, &problem()).as_ref()).norm_l2()
        };
        let [without, light, heavy] = [0.0, 100.0, 1e6].map(unlike);
        assert!(light < 0.5 * without && heavy < 1e-2, "{without} {light} {heavy}");
    }
}
