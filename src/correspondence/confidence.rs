//! How far a map agrees with its own way back.

use faer::MatRef;

use super::points;
use crate::geometry::{length, subtract};
use crate::numerics::{Cancelled, Watch};

/// The length, in units of √area of the sketch, over which confidence falls to 1/e.
const LENGTH: f64 = 0.1;

/// A number in [0, 1] for every vertex x of the sketch: exp(−d / (0.1 √area)), d the distance from x to the vertex that
/// the adjoint map Cᵀ takes T(x) back to, its nearest neighbour.
///
/// It tells where the map contradicts itself, not how far it is from the truth: a map consistently onto the wrong leg
/// is confident. It is not calibrated.
///
/// # Errors
/// [`Cancelled`] by the watcher.
pub fn of_points(
    c: MatRef<'_, f64>,
    phi: MatRef<'_, f64>,
    psi: MatRef<'_, f64>,
    map: &[u32],
    positions: &[[f64; 3]],
    area: f64,
    watch: &dyn Watch,
) -> Result<Vec<f64>, Cancelled> {
    let images = faer::Mat::from_fn(map.len(), psi.ncols(), |x, a| psi[(map[x] as usize, a)]);
    let back = points::by_nearest_neighbour(c.transpose(), images.as_ref(), phi, watch)?;
    Ok(positions
        .iter()
        .zip(back)
        .map(|(&x, returned)| {
            let distance = length(subtract(positions[returned as usize], x)) / area.sqrt();
            (-distance / LENGTH).exp()
        })
        .collect())
}
