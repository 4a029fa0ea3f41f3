//! Commutativity with the Laplacians [OBS+12, § 5.1].

use faer::Mat;

use super::{About, Commuting, Shape, weight};
use crate::functional_map::parameter::parameters;
use crate::functional_map::problem::Commutator;
use crate::functional_map::regulariser::Formula;
use crate::numerics::{Cancelled, Watch};

parameters! {
    /// w ‖C Λ_M − Λ_N C‖²_F.
    pub struct Laplacian {
        weight: f64 = weight(1.0),
    }
}

pub(super) static ABOUT: About = About {
    r#type: "laplacian",
    title: "Commutativity with the Laplacians",
    formula: Formula {
        text: "w ‖C Λ_M − Λ_N C‖²_F, eigenvalues in units of the largest",
        latex: r"w \|C \Lambda_M - \Lambda_N C\|_F^2",
    },
    equation: "",
    solver: "within the data term of the regulariser",
    parameters: Laplacian::PARAMETERS,
};

impl Commuting for Laplacian {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn commutators(&self, shapes: [Shape<'_>; 2], _: &dyn Watch) -> Result<Vec<Commutator>, Cancelled> {
        let largest = shapes.iter().flat_map(|shape| shape.eigenvalues).copied().fold(f64::MIN_POSITIVE, f64::max);
        let [x, y] = shapes.map(|Shape { eigenvalues, .. }| {
            let n = eigenvalues.len();
            Mat::from_fn(n, n, |i, j| if i == j { eigenvalues[i] / largest } else { 0.0 })
        });
        Ok(vec![Commutator { x, y, weight: self.weight }])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::functional_map::problem::Problem;
    use crate::functional_map::problem::least_squares;
    use crate::functional_map::regulariser::{L2, L2Solver, Regulariser};
    use crate::functional_map::solve::solve;
    use crate::mesh::solids::sheet;
    use crate::numerics::{Unwatched, random};
    use crate::spectral::{Boundary, spectrum};

    #[test]
    fn it_is_the_l2_term_with_the_differences_of_eigenvalues_as_weights() {
        let mesh = sheet(6, 5);
        let spectrum = spectrum(&mesh, 8, Boundary::Neumann, &Unwatched).unwrap().at_unit_area(8);
        let (none, mu) = (Mat::zeros(0, 0), (0..8).map(|i| 3.0 * f64::from(i)).collect::<Vec<_>>());
        let shape = |eigenvalues| Shape { mesh: &mesh, spectrum: &spectrum, eigenvalues, functions: &none };
        let commutators =
            Laplacian { weight: 5.0 }.commutators([shape(&spectrum.eigenvalues), shape(&mu)], &Unwatched).unwrap();
        let (a, b) = (random::normal(8, 30, 1), random::normal(8, 30, 2));
        let plain = Problem::new(a.as_ref(), b.as_ref()).unwrap();
        let mut problem = plain.clone();
        commutators.into_iter().for_each(|commutator| problem.commute(commutator).unwrap());
        let start = least_squares(&plain).unwrap();
        let none = serde_json::from_str::<Regulariser>(r#"{"type": "none"}"#).unwrap();
        let found = solve(&problem, &none, &Mat::ones(8, 8), start.clone(), &Unwatched).unwrap().c;
        let largest = spectrum.eigenvalues[7].max(21.0);
        let w = Mat::from_fn(8, 8, |i, j| ((mu[i] - spectrum.eigenvalues[j]) / largest).abs());
        let l2 = Regulariser::L2(L2 { gamma: 5.0, max_iterations: 1, tolerance: 0.0, solver: L2Solver::Exact });
        let wanted = solve(&plain, &l2, &w, start, &Unwatched).unwrap().c;
        assert!((found - &wanted).norm_max() < 1e-6 * wanted.norm_max());
    }
}
