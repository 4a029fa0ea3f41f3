//! A sketch made ready to be laid on a mesh.

use crate::alignment::contour::Contour;
use crate::alignment::error::AlignmentError;
use crate::deformation::as_rigid_as_possible::Elastic;
use crate::geometry::axes::{Axes, centred};
use crate::mesh::TriangleMesh;
use crate::mesh::connectivity::boundary_edges;
use crate::mesh::farthest_points::FarthestPoints;
use crate::mesh::geodesics::Marching;
use crate::numerics::{Cancelled, Share, Watch};
use crate::spectral::laplacian;

/// Points of the sketch between which distances are compared.
const SAMPLES: usize = 80;

/// A sketch at area 1 about its middle.
pub struct FlatShape {
    /// m × 2.
    pub positions: Vec<[f64; 2]>,
    pub triangles: Vec<[u32; 3]>,
    pub elastic: Elastic,
    /// The vertices of the outline, counter-clockwise; holes are left out.
    pub outline: Vec<u32>,
    /// Farthest points, and their distances within the figure to every vertex.
    pub samples: Vec<u32>,
    pub distances: Vec<Vec<f64>>,
    pub contour: Contour,
    /// Vertices that are drawn eyes.
    pub eyes: Vec<u32>,
    /// Area of the vertices, which sums to 1.
    pub masses: Vec<f64>,
    marching: Marching,
    scale: f64,
    /// The longest principal axis in the drawing, which points right in `positions`.
    axis: [f64; 2],
}

impl FlatShape {
    /// The sketch `mesh` (z = 0, counter-clockwise, connected) at area 1, its longest principal axis lying flat.
    ///
    /// # Errors
    /// [`AlignmentError`].
    pub fn new(mesh: &TriangleMesh, watch: &dyn Watch) -> Result<FlatShape, AlignmentError> {
        let area = mesh.area();
        let scale = area.sqrt();
        let masses: Vec<f64> =
            laplacian::mass(mesh, laplacian::Lumping::Barycentric).iter().map(|a| a / area).collect();
        let centred = centred(mesh.positions(), &masses, scale);
        let [right, up, _] = Axes::principal(&centred, &masses).longest();
        // Turned so that its longest axis lies flat.
        let positions: Vec<[f64; 2]> =
            centred.iter().map(|p| [right * p[0] + up * p[1], right * p[1] - up * p[0]]).collect();
        let marching = Marching::new(mesh);
        let (samples, mut distances) = farthest_points(&marching, &positions, watch)?;
        distances.iter_mut().flatten().for_each(|d| *d /= scale);
        Ok(FlatShape {
            elastic: Elastic::new(mesh)?,
            outline: outline(mesh),
            contour: Contour::of(&positions, mesh.triangles()),
            eyes: Vec::new(),
            masses,
            triangles: mesh.triangles().to_vec(),
            positions,
            samples,
            distances,
            marching,
            scale,
            axis: [right, up],
        })
    }

    /// The same with eyes at these of its vertices.
    pub fn with_eyes(self, eyes: Vec<u32>) -> FlatShape {
        FlatShape { eyes, ..self }
    }

    /// A direction of the drawing, y up, as one of the positions.
    pub fn turned(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let [right, up] = self.axis;
        [right * x + up * y, right * y - up * x]
    }

    /// The distances within the figure from a vertex to every other.
    ///
    /// # Errors
    /// [`Cancelled`] by the watcher.
    pub fn distances_from(&self, vertex: u32, watch: &dyn Watch) -> Result<Vec<f64>, Cancelled> {
        Ok(self.marching.distances(&[vertex], watch)?.iter().map(|d| d / self.scale).collect())
    }
}

/// Farthest points from the vertex nearest to the middle, with their distances in the units of the mesh.
fn farthest_points(
    marching: &Marching,
    positions: &[[f64; 2]],
    watch: &dyn Watch,
) -> Result<(Vec<u32>, Vec<Vec<f64>>), Cancelled> {
    let squared = |v: &usize| positions[*v][0].powi(2) + positions[*v][1].powi(2);
    let mut next = (0..positions.len()).min_by(|a, b| squared(a).total_cmp(&squared(b))).map(|v| v as u32);
    let count = SAMPLES.min(positions.len());
    let (mut samples, mut fields) = (Vec::with_capacity(count), Vec::with_capacity(count));
    let mut points = FarthestPoints::new(positions.len());
    while let Some(sample) = next.filter(|_| samples.len() < count) {
        let share = Share::of(watch, samples.len(), count);
        share.proceed(0.0)?;
        let field = marching.distances(&[sample], &share)?;
        samples.push(sample);
        points.choose(&field);
        next = points.farthest(0..positions.len() as u32);
        fields.push(field);
    }
    Ok((samples, fields))
}

/// The longest closed boundary, in the order of the triangles' winding.
fn outline(mesh: &TriangleMesh) -> Vec<u32> {
    // The mesh is manifold: a vertex of the boundary has one half-edge of it.
    let after: std::collections::BTreeMap<u32, u32> = boundary_edges(mesh).into_iter().map(|[a, b]| (a, b)).collect();
    let mut unseen: std::collections::BTreeSet<u32> = after.keys().copied().collect();
    let mut longest = Vec::new();
    while let Some(start) = unseen.first().copied() {
        let mut ring = Vec::new();
        let mut vertex = start;
        while unseen.remove(&vertex) {
            ring.push(vertex);
            vertex = after[&vertex];
        }
        if ring.len() > longest.len() {
            longest = ring;
        }
    }
    longest
}
