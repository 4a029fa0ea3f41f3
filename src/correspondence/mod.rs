//! From a functional map to points, and the refinement of both.
//!
//! A functional map C (l × k) takes functions on the sketch to functions on the mesh; the point map T asked for here
//! goes the same way, a vertex of the mesh for every vertex of the sketch. Φ (m × k) and Ψ (n × l) are the bases at the
//! vertices, orthonormal with respect to the masses.

pub mod confidence;
pub mod icp;
pub mod inverse;
pub mod points;
pub mod zoomout;

use faer::{Mat, MatRef};

/// How far along the surface a point answers for the mesh round it, in units of √area: pictures colour it, labels and functions are
/// taken over and regions carried as far.
pub const REACH: f64 = 0.12;

/// The functional map of a point map, Σ_x m(x) ψ(T(x)) φ(x)ᵀ (l × k): a unit mass at x goes to a unit mass at T(x).
///
/// Among all C it minimises Σ_x m(x) ‖C φ(x) − ψ(T(x))‖², Φ being orthonormal with respect to `mass` (m).
pub fn functional_map(phi: MatRef<'_, f64>, mass: &[f64], psi: MatRef<'_, f64>, map: &[u32]) -> Mat<f64> {
    let pulled = Mat::from_fn(map.len(), psi.ncols(), |x, a| mass[x] * psi[(map[x] as usize, a)]);
    pulled.transpose() * phi
}
