//! Bounded biharmonic weights [JBPS11].

use faer::Mat;
use sprs::{CsMat, TriMat};

use super::handles::Held;
use crate::mesh::edges::Edges;
use crate::numerics::bounded_quadratic::{BoundedQuadratic, QuadraticError};
use crate::numerics::{Share, Watch};
use crate::spectral::laplacian::{Lumping, mass, stiffness};

/// Raised with every change that alters weights: what was kept before is then not found any more.
pub const WEIGHTS_VERSION: u32 = 1;

/// How much above or below all its neighbours a weight is an extremum: of less nothing is to be seen.
const EXTREME: f64 = 1e-4;

/// The least mass of a vertex as a share of the mean: what has less would be as stiff as nothing else.
const LEAST_MASS: f64 = 1e-6;

/// How much every function of the handles moves every vertex of a drawing.
#[derive(Clone, Debug, PartialEq)]
pub struct Weights {
    /// m × h, each in `[0, 1]`; rows sum to 1.
    pub values: Mat<f64>,
    /// How many weights at vertices that are not held are larger, or smaller, than at all neighbours.
    pub extrema: usize,
}

/// The weights of a drawing that is held: of each function the smoothest from 0 to 1 by ∫ (Δw)², at the vertices that are
/// held those prescribed [eq. 5.2]. Each is found by itself, then all are divided by their sum, which differs from the
/// joint minimiser by some hundredths.
///
/// # Errors
/// [`QuadraticError`].
pub fn weights(held: &Held, watch: &dyn Watch) -> Result<Weights, QuadraticError> {
    let (n, functions) = (held.mesh.positions().len(), held.functions);
    let mut values = Mat::<f64>::zeros(n, functions);
    for (&vertex, prescribed) in &held.values {
        prescribed.iter().for_each(|&(function, weight)| values[(vertex as usize, function)] = weight);
    }
    let free: Vec<usize> = (0..n).filter(|&v| !held.values.contains_key(&(v as u32))).collect();
    if functions == 1 {
        values.fill(1.0);
    } else if !free.is_empty() {
        let energy = bilaplacian(held);
        let inner = BoundedQuadratic::new(among(&energy, &free))?;
        for function in 0..functions {
            let part = Share::of(watch, function, functions);
            // Free vertices are still at 0.
            let outer = |&v: &usize| {
                let row = energy.outer_view(v);
                row.map_or(0.0, |row| row.iter().map(|(u, entry)| entry * values[(u, function)]).sum())
            };
            let linear: Vec<f64> = free.iter().map(outer).collect();
            let found = inner.minimiser(&linear, &part)?;
            free.iter().zip(found).for_each(|(&v, weight)| values[(v, function)] = weight);
        }
        for &v in &free {
            // Within the bounds no weight is 0, so that there is a sum.
            let sum: f64 = (0..functions).map(|function| values[(v, function)]).sum();
            (0..functions).for_each(|function| values[(v, function)] /= sum);
        }
    }
    Ok(Weights { extrema: extrema(held, &values), values: values.subrows(0, held.drawing).to_owned() })
}

/// L M⁻¹ L times the area, of no unit: wᵀ of it w is the energy of w.
fn bilaplacian(held: &Held) -> CsMat<f64> {
    let l = stiffness(&held.mesh);
    let area = held.mesh.area();
    let masses = mass(&held.mesh, Lumping::Barycentric);
    let least = LEAST_MASS * area / masses.len() as f64;
    let mut weighted = l.clone();
    for (mut row, mass) in weighted.outer_iterator_mut().zip(masses) {
        row.iter_mut().for_each(|(_, entry)| *entry *= area / mass.max(least));
    }
    &l * &weighted
}

/// The rows and columns of a symmetric matrix of these numbers, ascending; exactly symmetric.
fn among(matrix: &CsMat<f64>, chosen: &[usize]) -> CsMat<f64> {
    let mut place = vec![None; matrix.rows()];
    chosen.iter().enumerate().for_each(|(own, &v)| place[v] = Some(own));
    let mut entries = TriMat::with_capacity((chosen.len(), chosen.len()), matrix.nnz() + chosen.len());
    for (&value, (i, j)) in matrix.iter() {
        if let (Some(i), Some(j)) = (place[i], place[j]) {
            // Half of either triangle to both, as rounding is not the same in them.
            entries.add_triplet(i, j, 0.5 * value);
            entries.add_triplet(j, i, 0.5 * value);
        }
    }
    (0..chosen.len()).for_each(|i| entries.add_triplet(i, i, 0.0));
    entries.to_csr()
}

fn extrema(held: &Held, values: &Mat<f64>) -> usize {
    let n = values.nrows();
    let (mut above, mut below) =
        (Mat::from_fn(n, values.ncols(), |_, _| true), Mat::from_fn(n, values.ncols(), |_, _| true));
    for edge in Edges::of(held.mesh.triangles()).iter() {
        let [a, b] = edge.ends().map(|v| v as usize);
        for function in 0..values.ncols() {
            for (v, u) in [(a, b), (b, a)] {
                let difference = values[(v, function)] - values[(u, function)];
                above[(v, function)] &= difference > EXTREME;
                below[(v, function)] &= difference < -EXTREME;
            }
        }
    }
    let free = (0..n).filter(|&v| !held.values.contains_key(&(v as u32)));
    free.flat_map(|v| (0..values.ncols()).map(move |function| (v, function)))
        .filter(|&at| above[at] || below[at])
        .count()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::deformation::handles::Handle;
    use crate::mesh::solids::sheet;
    use crate::numerics::Unwatched;

    fn held(handles: &[Handle]) -> Held {
        Held::new(&sheet(24, 12), handles).unwrap()
    }

    fn handles() -> Vec<Handle> {
        vec![
            Handle::Point([0.1, 0.1]),
            Handle::Point([1.3, 0.6]),
            Handle::Bone([[0.5, 0.3], [0.9, 0.4]]),
            Handle::Point([1.3, 0.1]),
        ]
    }

    fn column(weights: &Weights, function: usize) -> Vec<f64> {
        (0..weights.values.nrows()).map(|v| weights.values[(v, function)]).collect()
    }

    #[test]
    fn weights_keep_their_bounds_their_sum_and_what_is_held() {
        let cage = Handle::Cage(vec![[-0.2, -0.2], [1.7, -0.2], [1.7, 1.0], [-0.2, 1.0]]);
        for handles in [handles(), vec![cage, Handle::Point([0.5, 0.3])]] {
            let held = held(&handles);
            let weights = weights(&held, &Unwatched).unwrap();
            assert_eq!((weights.values.nrows(), weights.values.ncols()), (25 * 13, held.functions));
            for v in 0..weights.values.nrows() {
                let row = weights.values.row(v);
                assert!(row.iter().all(|w| (-1e-12..=1.0 + 1e-12).contains(w)));
                assert!((row.iter().sum::<f64>() - 1.0).abs() < 1e-12);
            }
            for (&vertex, prescribed) in held.values.iter().filter(|(v, _)| (**v as usize) < held.drawing) {
                prescribed.iter().for_each(|&(f, w)| assert_eq!(weights.values[(vertex as usize, f)], w));
            }
        }
    }

    #[test]
    fn the_energy_is_symmetric_and_that_of_a_constant_is_none() {
        let held = held(&handles());
        let energy = bilaplacian(&held);
        let free: Vec<usize> = (0..held.drawing).filter(|&v| !held.values.contains_key(&(v as u32))).collect();
        let inner = among(&energy, &free);
        let constant: f64 = energy.iter().map(|(value, _)| value).sum();
        assert!(constant.abs() < 1e-6 * energy.data().iter().fold(0.0, |most: f64, x| most.max(x.abs())));
        for (value, (i, j)) in inner.iter() {
            assert_eq!(inner.get(j, i), Some(value));
        }
    }

    #[test]
    fn two_handles_share_every_place_and_mirror_images_mirror_weights() {
        let [left, right] = [[0.0, 0.35], [1.414, 0.35]];
        let one = weights(&held(&[Handle::Point(left), Handle::Point(right)]), &Unwatched).unwrap();
        let other = weights(&held(&[Handle::Point(right), Handle::Point(left)]), &Unwatched).unwrap();
        for (a, b) in column(&one, 0).iter().zip(column(&other, 1)) {
            assert!((a - b).abs() < 1e-9);
        }
        // Along the middle of the sheet weights fall from one handle to the other.
        let middle: Vec<f64> = (0..25).map(|i| one.values[(6 * 25 + i, 0)]).collect();
        assert!(middle.windows(2).all(|pair| pair[0] > pair[1]), "{middle:?}");
        assert!((middle[12] - 0.5).abs() < 0.02, "{}", middle[12]);
        assert_eq!(one.extrema, 0);
    }

    #[test]
    fn one_handle_moves_everything() {
        let weights = weights(&held(&[Handle::Point([0.3, 0.3])]), &Unwatched).unwrap();
        assert!(column(&weights, 0).iter().all(|&weight| weight == 1.0));
    }
}
