//! Commutativity with descriptors [NO17]: multiplying by a function and then mapping is mapping and then multiplying.

use faer::{Mat, MatRef};

use super::{About, Commuting, Shape, projected, weight};
use crate::functional_map::parameter::parameters;
use crate::functional_map::problem::Commutator;
use crate::functional_map::regulariser::Formula;
use crate::numerics::{Cancelled, Watch};
use crate::spectral::Spectrum;

parameters! {
    /// w Σ_f ‖C M_f − M_g C‖²_F.
    pub struct Descriptors {
        weight: f64 = weight(1.0),
    }
}

pub(super) static ABOUT: About = About {
    r#type: "descriptors",
    title: "Commutativity with descriptors",
    formula: Formula {
        text: "w/q Σ ‖C Φᵀ M diag(f) Φ − Ψᵀ M diag(g) Ψ C‖²_F over q corresponding functions f and g",
        latex: r"\tfrac{w}{q} \sum_{f, g} \|C \Phi^T A_M \operatorname{diag}(f) \Phi - \Psi^T A_N \operatorname{diag}(g) \Psi C\|_F^2",
    },
    equation: "",
    solver: "within the data term of the regulariser",
    parameters: Descriptors::PARAMETERS,
};

impl Commuting for Descriptors {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn commutators(&self, [sketch, mesh]: [Shape<'_>; 2], watch: &dyn Watch) -> Result<Vec<Commutator>, Cancelled> {
        let count = sketch.functions.ncols().min(mesh.functions.ncols());
        let each = (0..count).map(|f| {
            Ok(Commutator {
                x: multiplication(sketch.spectrum, sketch.functions.as_ref(), f, watch)?,
                y: multiplication(mesh.spectrum, mesh.functions.as_ref(), f, watch)?,
                weight: self.weight / count as f64,
            })
        });
        each.collect()
    }
}

/// Φᵀ M diag(f) Φ (k × k) for column f of `functions`: multiplication by it in the basis.
fn multiplication(
    spectrum: &Spectrum,
    functions: MatRef<'_, f64>,
    f: usize,
    watch: &dyn Watch,
) -> Result<Mat<f64>, Cancelled> {
    let phi = &spectrum.eigenfunctions;
    projected(phi.as_ref(), |x, i| spectrum.mass[x] * functions[(x, f)] * phi[(x, i)], watch)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::solids::sheet;
    use crate::numerics::Unwatched;
    use crate::spectral::{Boundary, spectrum};

    #[test]
    fn the_identity_of_a_shape_commutes_with_its_own_functions() {
        let mesh = sheet(7, 5);
        let spectrum = spectrum(&mesh, 9, Boundary::Neumann, &Unwatched).unwrap().at_unit_area(9);
        let n = mesh.positions().len();
        let functions = Mat::from_fn(n, 3, |x, f| ((x * (f + 1)) as f64).sin());
        let shape =
            Shape { mesh: &mesh, spectrum: &spectrum, eigenvalues: &spectrum.eigenvalues, functions: &functions };
        let commutators = Descriptors { weight: 3.0 }.commutators([shape, shape], &Unwatched).unwrap();
        assert_eq!(commutators.len(), 3);
        for Commutator { x, y, weight } in commutators {
            assert!((&x - &y).norm_max() < 1e-12 && weight == 1.0);
            assert!((&x - x.transpose()).norm_max() < 1e-12);
        }
    }

    #[test]
    fn multiplication_by_a_constant_is_the_identity_times_it() {
        let mesh = sheet(7, 5);
        let spectrum = spectrum(&mesh, 9, Boundary::Neumann, &Unwatched).unwrap().at_unit_area(9);
        let twice = Mat::full(mesh.positions().len(), 1, 2.0);
        let found = multiplication(&spectrum, twice.as_ref(), 0, &Unwatched).unwrap();
        assert!((found - 2.0 * Mat::<f64>::identity(9, 9)).norm_max() < 1e-9);
    }
}
