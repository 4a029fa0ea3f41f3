//! From points on the mesh back to the sketch: for vertices of the mesh a vertex of the sketch.

use faer::{Mat, MatRef};

use super::{REACH, points};
use crate::mesh::TriangleMesh;
use crate::mesh::geodesics::Marching;
use crate::numerics::{Cancelled, Watch};

/// For every vertex of the mesh the place among `answers`, which are vertices of it, of the nearest along the surface, of equals
/// the first; none beyond [`REACH`].
///
/// # Errors
/// [`Cancelled`] by the watcher.
///
/// # Panics
/// Where an answer is not a vertex of the mesh.
pub fn of_points(mesh: &TriangleMesh, answers: &[u32], watch: &dyn Watch) -> Result<Vec<Option<usize>>, Cancelled> {
    Marching::new(mesh).cells_within(answers, REACH * mesh.area().sqrt(), watch)
}

/// For every vertex y of the mesh argmin_x ‖C φ(x) − ψ(y)‖: the nearest neighbour of row y of Ψ (n × l) among the columns of
/// C Φᵀ, Φ being m × k; of equals the first.
///
/// # Errors
/// [`Cancelled`] by the watcher.
pub fn of_map(
    c: MatRef<'_, f64>,
    phi: MatRef<'_, f64>,
    psi: MatRef<'_, f64>,
    watch: &dyn Watch,
) -> Result<Vec<u32>, Cancelled> {
    let images = phi * c.transpose();
    points::by_nearest_neighbour(Mat::<f64>::identity(c.nrows(), c.nrows()).as_ref(), psi, images.as_ref(), watch)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::solids::sheet;
    use crate::numerics::{Unwatched, random};

    #[test]
    fn the_nearest_answer_is_found_along_the_surface() {
        let mesh = sheet(20, 20);
        let found = of_points(&mesh, &[0, 5, 0], &Unwatched).unwrap();
        assert_eq!((found[0], found[1], found[4], found[5], found[10]), (Some(0), Some(0), Some(1), Some(1), None));
    }

    #[test]
    fn the_inverse_of_a_permutation_is_its_inverse() {
        let psi = random::normal(30, 8, 3);
        let c = random::normal(8, 8, 4);
        // φ(x) = C⁻¹ ψ(T(x)) with T(x) = 7 x mod 30.
        let inverse = {
            use faer::linalg::solvers::{PartialPivLu, Solve};
            PartialPivLu::new(c.as_ref()).solve(Mat::<f64>::identity(8, 8))
        };
        let of = |x: usize| 7 * x % 30;
        let moved = Mat::from_fn(30, 8, |x, j| psi[(of(x), j)]);
        let phi = moved * inverse.transpose();
        let back = of_map(c.as_ref(), phi.as_ref(), psi.as_ref(), &Unwatched).unwrap();
        assert!((0..30).all(|x| back[of(x)] == x as u32), "{back:?}");
    }
}
