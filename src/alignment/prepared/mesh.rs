//! Everything of a mesh that no sketch is needed for.

use serde::{Deserialize, Serialize};

use super::directions::{canonical_directions, half_sphere};
use super::limbs::{Limb, limbs};
use super::sampled_distances::SampledDistances;
use super::standing::{self, Body, Up};
use super::symmetry::{Symmetry, plane};
use crate::alignment::contour::view::View;
use crate::geometry::axes::{Axes, centred};
use crate::geometry::{cross, dot};
use crate::mesh::TriangleMesh;
use crate::mesh::connectivity::boundary_vertices;
use crate::mesh::normals::vertex_normals;
use crate::numerics::{Cancelled, Watch};
use crate::spectral::laplacian::{Lumping, mass};

/// Raised with every change that alters what is made of a mesh: what was kept before is then not found any more.
pub const PREPARATION_VERSION: u32 = 4;

/// Points that distances are known from.
const SAMPLES: usize = 120;
/// Directions of the half sphere.
const DIRECTIONS: usize = 40;

/// A mesh at area 1 about its centre, along its principal axes, with its views: the same however the mesh lies.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PreparedMesh {
    /// The axes of `positions`, of the symmetry and of the frames, in those of the mesh.
    pub axes: Axes,
    pub positions: Vec<[f64; 3]>,
    /// Area of the vertices, which sums to 1.
    pub masses: Vec<f64>,
    pub triangles: Vec<[u32; 3]>,
    /// Whether no triangle is seen from behind: none has a free edge, and all are counter-clockwise from outside.
    pub closed: bool,
    pub symmetry: Symmetry,
    pub distances: SampledDistances,
    /// For every sample of the distances the direction the surface faces there, of length 1.
    pub normals: Vec<[f64; 3]>,
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
        let masses: Vec<f64> = mass(mesh, Lumping::Barycentric).iter().map(|a| a / area).collect();
        let centred = centred(mesh.positions(), &masses, scale);
        let axes = Axes::principal(&centred, &masses);
        let unit = mesh.similar(centred.into_iter().map(|p| axes.along(p)).collect());
        watch.proceed(0.0)?;
        let (positions, triangles) = (unit.positions(), unit.triangles());
        let distances = SampledDistances::new(&unit, SAMPLES, watch)?;
        let symmetry = plane(positions, &masses, || watch.proceed(0.5))?;
        let limbs = limbs(&unit, &distances, watch)?;
        watch.proceed(0.5)?;
        let closed = is_seen_from_outside(&unit);
        watch.proceed(0.5)?;
        let facing = vertex_normals(&unit);
        let normals = distances.samples.iter().map(|&sample| facing[sample as usize]).collect();
        let view = |&direction: &[f64; 3]| {
            watch.proceed(0.5)?;
            Ok(View::lying_flat(direction, positions, triangles, closed))
        };
        let canonical = canonical_directions(positions, &masses, symmetry.normal);
        let canonical = canonical.iter().map(view).collect::<Result<_, Cancelled>>()?;
        let sphere = half_sphere(DIRECTIONS).iter().map(view).collect::<Result<_, Cancelled>>()?;
        Ok(PreparedMesh {
            axes,
            positions: positions.to_vec(),
            masses,
            triangles: triangles.to_vec(),
            closed,
            symmetry,
            distances,
            normals,
            limbs,
            canonical,
            sphere,
        })
    }

    /// Which way is up on the mesh, `agreed` being what the format of its file says: as [`standing::up`].
    pub fn up(&self, agreed: Option<[f64; 3]>) -> Up {
        let Self { positions, masses, axes, symmetry, .. } = self;
        standing::found(&Body { positions, masses, axes, symmetry }, agreed)
    }
}

/// Whether the mesh has no boundary, and its triangles are counter-clockwise from outside.
fn is_seen_from_outside(mesh: &TriangleMesh) -> bool {
    let volume = |t: &[u32; 3]| {
        let [a, b, c] = t.map(|v| mesh.positions()[v as usize]);
        dot(a, cross(b, c))
    };
    !boundary_vertices(mesh).contains(&true) && mesh.triangles().iter().map(volume).sum::<f64>() > 0.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{length, subtract};
    use crate::mesh::solids::{sheet, sphere, star, turned};
    use crate::numerics::Unwatched;

    #[test]
    fn a_mesh_is_prepared_the_same_however_it_lies() {
        let body = star(0.0);
        let bent = |&[x, y, z]: &[f64; 3]| [3.0 * x, 1.5 * y, z + 0.3 * x * x];
        let lying: Vec<[f64; 3]> = body.positions().iter().map(bent).collect();
        let prepared = |positions: Vec<[f64; 3]>| {
            let mesh = TriangleMesh::new(positions, body.triangles().to_vec()).unwrap();
            PreparedMesh::new(&mesh, &Unwatched).unwrap()
        };
        let own = prepared(lying.clone());
        let angles = [0.7, 2.1];
        let other = prepared(lying.iter().map(|&p| turned(p, angles).map(|x| 40.0 * x + 7.0)).collect());
        for (&p, &q) in own.positions.iter().zip(&other.positions) {
            assert!(length(subtract(p, q)) < 1e-9);
        }
        let views = |mesh: &PreparedMesh| [&mesh.canonical[..], &mesh.sphere].concat();
        for (own_view, other_view) in views(&own).iter().zip(&views(&other)) {
            let (a, b) = (own.axes.frame_back(&own_view.frame), other.axes.frame_back(&other_view.frame));
            // Simplex search and pixels answer rounding by a little more.
            assert!(length(subtract(turned(a.toward_camera, angles), b.toward_camera)) < 1e-6);
            assert!(length(subtract(turned(a.up, angles), b.up)) < 1e-2);
        }
    }

    #[test]
    fn a_closed_mesh_is_seen_from_outside_unless_it_is_inside_out() {
        let ball = sphere(8, 16);
        assert!(is_seen_from_outside(&ball) && !is_seen_from_outside(&sheet(3, 3)));
        let reversed = ball.triangles().iter().map(|&[a, b, c]| [a, c, b]).collect();
        assert!(!is_seen_from_outside(&TriangleMesh::new(ball.positions().to_vec(), reversed).unwrap()));
    }
}
