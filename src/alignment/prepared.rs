//! Everything of a mesh that no sketch is needed for.

use serde::{Deserialize, Serialize};

use super::frame::Frame;
use super::limbs::{Limb, limbs};
use super::sampled_distances::SampledDistances;
use super::symmetry::{Symmetry, plane};
use super::view::View;
use super::views::{canonical_directions, half_sphere};
use crate::mesh::TriangleMesh;
use crate::numerics::{Cancelled, Watch};
use crate::spectral::laplacian::{Lumping, mass};

/// Raised with every change that alters what is made of a mesh: what was kept before is then not found any more.
pub const PREPARATION_VERSION: u32 = 1;

/// Points that distances are known from.
const SAMPLES: usize = 120;
/// Directions of the half sphere.
const DIRECTIONS: usize = 40;

/// A mesh at area 1 about the mean of its vertices, with its views.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PreparedMesh {
    pub positions: Vec<[f64; 3]>,
    pub triangles: Vec<[u32; 3]>,
    pub symmetry: Symmetry,
    pub distances: SampledDistances,
    pub limbs: Vec<Limb>,
    /// The view along the normal of the plane of symmetry, then those within the plane.
    pub canonical: Vec<View>,
    /// Views from all around.
    pub sphere: Vec<View>,
}

impl PreparedMesh {
    /// The mesh, connected and without unused vertices, made ready.
    ///
    /// # Errors
    /// [`Cancelled`] by the watcher.
    pub fn new(mesh: &TriangleMesh, watch: &dyn Watch) -> Result<PreparedMesh, Cancelled> {
        let area = mesh.area();
        let scale = area.sqrt();
        let n = mesh.positions().len() as f64;
        let middle: [f64; 3] = std::array::from_fn(|i| mesh.positions().iter().map(|p| p[i]).sum::<f64>() / n);
        let positions: Vec<[f64; 3]> =
            mesh.positions().iter().map(|p| std::array::from_fn(|i| (p[i] - middle[i]) / scale)).collect();
        let masses: Vec<f64> = mass(mesh, Lumping::Barycentric).iter().map(|a| a / area).collect();
        let triangles = mesh.triangles().to_vec();
        let unit = TriangleMesh::new(positions, triangles).expect("a valid mesh of another size is valid");
        let (positions, triangles) = (unit.positions(), unit.triangles());
        let distances = SampledDistances::new(&unit, SAMPLES, watch)?;
        let symmetry = plane(positions, &masses);
        let limbs = limbs(&unit, &distances, watch)?;
        let view = |&direction: &[f64; 3]| {
            watch.proceed(0.5)?;
            Ok(View::through(Frame::looking_from(direction), positions, triangles))
        };
        let canonical = canonical_directions(positions, &masses, symmetry.normal);
        let canonical = canonical.iter().map(view).collect::<Result<_, Cancelled>>()?;
        let sphere = half_sphere(DIRECTIONS).iter().map(view).collect::<Result<_, Cancelled>>()?;
        Ok(PreparedMesh {
            positions: positions.to_vec(),
            triangles: triangles.to_vec(),
            symmetry,
            distances,
            limbs,
            canonical,
            sphere,
        })
    }
}
