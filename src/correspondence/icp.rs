//! Iterative closest points in the space of the basis, with an orthonormal C: [OBS+12, §6.2], §2.2.1.

use faer::{Mat, MatRef};

use super::functional_map;
use super::points::Target;
use crate::numerics::{Cancelled, DecompositionError, Watch};

/// Why the refinement ended without a map.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum IcpError {
    #[error(transparent)]
    Cancelled(#[from] Cancelled),
    #[error(transparent)]
    Decomposition(#[from] DecompositionError),
}

/// The orthonormal map (k × k) after at most `iterations` rounds of nearest points and best rotation; it ends where
/// the points stay.
///
/// # Errors
/// [`IcpError`].
pub fn refined(
    c: Mat<f64>,
    phi: MatRef<'_, f64>,
    mass: &[f64],
    psi: MatRef<'_, f64>,
    iterations: usize,
    watch: &dyn Watch,
) -> Result<Mat<f64>, IcpError> {
    let on_mesh = Target::new(psi);
    let mut c = c;
    let mut last = Vec::new();
    for round in 0..iterations {
        watch.proceed(round as f64 / iterations as f64)?;
        let map = on_mesh.by_nearest_neighbour(c.as_ref(), phi, watch)?;
        if map == last {
            break;
        }
        // The orthonormal C nearest to the map of these points: U Vᵀ of its singular value decomposition.
        let target = functional_map(phi, mass, psi, &map);
        let svd = target
            .svd()
            .map_err(|_| DecompositionError::SingularValues { rows: target.nrows(), columns: target.ncols() })?;
        c = svd.U() * svd.V().transpose();
        last = map;
    }
    Ok(c)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::Unwatched;

    #[test]
    fn a_disturbed_identity_settles_on_it_and_c_is_orthonormal() {
        let n = 150;
        let basis = Mat::from_fn(n, 8, |x, i| {
            let scale = if i == 0 { 1.0f64 } else { 2.0 };
            scale.sqrt() * (std::f64::consts::PI * i as f64 * (x as f64 + 0.5) / n as f64).cos()
        });
        let mass = vec![1.0 / n as f64; n];
        let start = Mat::from_fn(8, 8, |i, j| if i == j { 0.9 } else { 0.02 * ((i * 8 + j) as f64).sin() });
        let c = refined(start, basis.as_ref(), &mass, basis.as_ref(), 20, &Unwatched).unwrap();
        assert!((c.transpose() * &c - Mat::<f64>::identity(8, 8)).norm_max() < 1e-12);
        assert!((&c - Mat::<f64>::identity(8, 8)).norm_max() < 1e-3);
    }
}
