//! ZoomOut: a map of few eigenfunctions carried to many by turns of points and map [MRR+19], rectangular C included.

use faer::{Mat, MatRef};

use super::functional_map;
use super::points::Target;
use crate::numerics::{Cancelled, Watch};

/// Eigenfunctions of the sketch added in a step.
const STEP: usize = 5;

/// The map (l' × k) for the first k = `phi.ncols()` eigenfunctions of the sketch and l' = `psi.ncols()` of the mesh,
/// from a smaller C; the number of the mesh's eigenfunctions grows in proportion. Points are looked for `among` these vertices of the
/// mesh, where there are some: on a part that the sketch is known to show.
///
/// # Errors
/// [`Cancelled`] by the watcher, asked at every block of every step.
pub fn refined(
    c: Mat<f64>,
    phi: MatRef<'_, f64>,
    mass: &[f64],
    psi: MatRef<'_, f64>,
    among: Option<&[u32]>,
    watch: &dyn Watch,
) -> Result<Mat<f64>, Cancelled> {
    let part = among.map(|among| Mat::from_fn(among.len(), psi.ncols(), |i, j| psi[(among[i] as usize, j)]));
    let psi = part.as_ref().map_or(psi, Mat::as_ref);
    let (last_l, last_k) = (psi.ncols(), phi.ncols());
    let (first_l, first_k) = c.shape();
    let target = Target::new(psi);
    let mut c = c;
    while c.ncols() < last_k || c.nrows() < last_l {
        let k = c.ncols();
        let map = target.by_nearest_neighbour(c.as_ref(), phi.subcols(0, k), watch)?;
        let k = (k + STEP).min(last_k);
        let l = if k == last_k { last_l } else { first_l + (last_l - first_l) * (k - first_k) / (last_k - first_k) };
        c = functional_map(phi.subcols(0, k), mass, psi.subcols(0, l), &map);
    }
    Ok(c)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::Unwatched;

    /// Orthonormal cosines on n points of a line.
    fn cosines(n: usize, k: usize) -> (Mat<f64>, Vec<f64>) {
        let basis = Mat::from_fn(n, k, |x, i| {
            let scale = if i == 0 { 1.0f64 } else { 2.0 };
            scale.sqrt() * (std::f64::consts::PI * i as f64 * (x as f64 + 0.5) / n as f64).cos()
        });
        (basis, vec![1.0 / n as f64; n])
    }

    #[test]
    fn a_truncated_identity_is_carried_up_to_the_identity() {
        let (basis, mass) = cosines(200, 31);
        let c = refined(Mat::identity(6, 6), basis.as_ref(), &mass, basis.as_ref(), None, &Unwatched).unwrap();
        assert!((&c - Mat::<f64>::identity(31, 31)).norm_max() < 1e-10);
    }

    #[test]
    fn a_rectangular_map_grows_in_proportion() {
        let (phi, mass) = cosines(200, 20);
        let (psi, _) = cosines(300, 30);
        let start = Mat::<f64>::from_fn(9, 6, |i, j| if i == j { 1.0 } else { 0.0 });
        let c = refined(start, phi.as_ref(), &mass, psi.as_ref(), None, &Unwatched).unwrap();
        assert_eq!(c.shape(), (30, 20));
    }

    #[test]
    fn on_a_part_the_points_of_the_part_are_found() {
        // The sketch is the first half of a line.
        let ((phi, mass), (psi, _)) = (cosines(100, 20), cosines(200, 40));
        let right: Vec<u32> = (0..100).collect();
        let start = functional_map(phi.subcols(0, 5), &mass, psi.subcols(0, 10), &right);
        let away = |among: Option<&[u32]>| {
            let c = refined(start.clone(), phi.as_ref(), &mass, psi.as_ref(), among, &Unwatched).unwrap();
            let map = Target::new(psi.as_ref()).by_nearest_neighbour(c.as_ref(), phi.as_ref(), &Unwatched).unwrap();
            map.iter().zip(&right).map(|(a, b)| f64::from(a.abs_diff(*b))).sum::<f64>() / 100.0
        };
        let (with, without) = (away(Some(&right)), away(None));
        assert!(with < 1.0 && with <= without, "{with} {without}");
    }
}
