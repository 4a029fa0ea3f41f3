//! Preservation of orientation [RPWO18]: which way gradients turn into each other is kept, so that left is not taken for right.

use faer::Mat;

use super::{About, Commuting, ROUND, Shape, projected, weight};
use crate::functional_map::parameter::parameters;
use crate::functional_map::problem::Commutator;
use crate::functional_map::regulariser::Formula;
use crate::numerics::{Cancelled, Watch};

parameters! {
    /// w Σ_f ‖C O_f − O_g C‖²_F.
    pub struct Orientation {
        weight: f64 = weight(1.0),
    }
}

pub(super) static ABOUT: About = About {
    r#type: "orientation",
    title: "Preservation of orientation",
    formula: Formula {
        text: "w/q Σ ‖C O_f − O_g C‖²_F over q corresponding functions f and g, O_f h = ⟨∇f × ∇h, n⟩, each in units of its norm",
        latex: r"\tfrac{w}{q} \sum_{f, g} \|C O_f - O_g C\|_F^2, \; O_f h = \langle \nabla f \times \nabla h, n \rangle",
    },
    equation: "",
    solver: "within the data term of the regulariser",
    parameters: Orientation::PARAMETERS,
};

impl Commuting for Orientation {
    fn about(&self) -> &'static About {
        &ABOUT
    }

    fn commutators(&self, [sketch, mesh]: [Shape<'_>; 2], watch: &dyn Watch) -> Result<Vec<Commutator>, Cancelled> {
        let count = sketch.functions.ncols().min(mesh.functions.ncols());
        let each = (0..count).map(|f| {
            Ok(Commutator {
                x: of_unit(turning(sketch, f, watch)?),
                y: of_unit(turning(mesh, f, watch)?),
                weight: self.weight / count as f64,
            })
        });
        each.collect()
    }
}

/// Gradients of different shapes differ in size; which way they turn is what counts.
fn of_unit(operator: Mat<f64>) -> Mat<f64> {
    let norm = operator.norm_l2();
    if norm > 0.0 { operator * (1.0 / norm) } else { operator }
}

/// The operator h ↦ ⟨∇f × ∇h, n⟩ in the basis, k × k, f being column `f` of the functions.
///
/// On a triangle with corners i, j, k counter-clockwise around n the value is ((f_j − f_i)(h_k − h_i) − (f_k − f_i)(h_j − h_i)) over
/// twice its area, so that areas cancel; each corner has a third of it.
fn turning(shape: Shape<'_>, f: usize, watch: &dyn Watch) -> Result<Mat<f64>, Cancelled> {
    let (phi, functions) = (&shape.spectrum.eigenfunctions, shape.functions);
    let k = phi.ncols();
    // Rows of h ↦ ∫ (hat function of a vertex) ⟨∇f × ∇h, n⟩, applied to the basis; at any scale, for areas cancel.
    let mut turned = Mat::<f64>::zeros(phi.nrows(), k);
    for (t, &[i, j, l]) in shape.mesh.triangles().iter().enumerate() {
        if t.is_multiple_of(ROUND) {
            watch.proceed(0.0)?;
        }
        let [i, j, l] = [i, j, l].map(|v| v as usize);
        let (along, beside) = (functions[(j, f)] - functions[(i, f)], functions[(l, f)] - functions[(i, f)]);
        for b in 0..k {
            let value = along * (phi[(l, b)] - phi[(i, b)]) - beside * (phi[(j, b)] - phi[(i, b)]);
            for v in [i, j, l] {
                turned[(v, b)] += value / 6.0;
            }
        }
    }
    projected(phi.as_ref(), |x, i| turned[(x, i)], watch)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TriangleMesh;
    use crate::mesh::solids::sheet;
    use crate::numerics::Unwatched;
    use crate::spectral::{Boundary, Spectrum, spectrum};

    fn of(mesh: &TriangleMesh) -> Spectrum {
        spectrum(mesh, 9, Boundary::Neumann, &Unwatched).unwrap().at_unit_area(9)
    }

    /// The sheet turned over: the same places, seen from behind.
    fn turned_over(mesh: &TriangleMesh) -> TriangleMesh {
        let triangles = mesh.triangles().iter().map(|&[a, b, c]| [a, c, b]).collect();
        TriangleMesh::new(mesh.positions().to_vec(), triangles).unwrap()
    }

    #[test]
    fn gradients_turn_the_other_way_on_a_mirrored_shape() {
        let (front, behind) = (sheet(8, 5), turned_over(&sheet(8, 5)));
        let spectrum = of(&front);
        let along =
            Mat::from_fn(front.positions().len(), 1, |x, _| front.positions()[x][0] + front.positions()[x][1].powi(2));
        let shape = |mesh| Shape { mesh, spectrum: &spectrum, eigenvalues: &spectrum.eigenvalues, functions: &along };
        let (x, y) = (turning(shape(&front), 0, &Unwatched).unwrap(), turning(shape(&behind), 0, &Unwatched).unwrap());
        assert!(x.norm_max() > 0.1 && (&x + &y).norm_max() < 1e-12 * x.norm_max());
        // The identity is orientation-preserving from front to front and the worst there is from front to back.
        let failure = |other| {
            let [Commutator { x, y, .. }] =
                &Orientation { weight: 1.0 }.commutators([shape(&front), shape(other)], &Unwatched).unwrap()[..]
            else {
                panic!("one function has one commutator");
            };
            (x - y).norm_l2()
        };
        assert!(failure(&front) < 1e-12 && (failure(&behind) - 2.0).abs() < 1e-12);
    }

    #[test]
    fn on_a_plane_it_is_the_cross_product_of_gradients() {
        let mesh = sheet(6, 6);
        let n = mesh.positions().len();
        // f = x, h = y: ∇f × ∇h = 1 everywhere, whose coefficients are those of the constant.
        let (spectrum, f) = (of(&mesh), Mat::from_fn(n, 1, |x, _| mesh.positions()[x][0]));
        let mut with_y = spectrum.clone();
        with_y.eigenfunctions = Mat::from_fn(n, 1, |x, _| mesh.positions()[x][1]);
        let shape = Shape { mesh: &mesh, spectrum: &with_y, eigenvalues: &[0.0], functions: &f };
        // ∫ h ⟨∇f × ∇h, n⟩ = ∫ y over the sheet.
        let wanted: f64 = mesh
            .triangles()
            .iter()
            .map(|t| {
                let corners = t.map(|v| mesh.positions()[v as usize]);
                crate::geometry::triangle_area(corners) * corners.iter().map(|p| p[1]).sum::<f64>() / 3.0
            })
            .sum();
        assert!((turning(shape, 0, &Unwatched).unwrap()[(0, 0)] - wanted).abs() < 1e-12);
    }
}
