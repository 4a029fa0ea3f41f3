//! A pose as a linear function of the maps of its handles.

use faer::Mat;

use super::PoseError;
use super::of_file::beside;
use super::outcome::HandleWeights;
use super::seen::Seen;
use crate::deformation::transfer::Transfer;
use crate::mesh::file_mesh::FileMesh;
use crate::pipeline::outcome::MatchResult;
use crate::sketch::Sketch;

/// The basis in which a pose is linear in the maps of its h weights (eq. 5.1, 5.5), of a file of n vertices.
///
/// With (a b c / d e f) the map of the i-th weight, in the coordinates of the sketch's upload, vertex v is at
/// `rest[v] + (X − places[v][0]) axes[0] + (Y − places[v][1]) axes[1]`, where X is the sum of `values[v][3 i ..]` · (a b c)
/// over all weights and Y that with (d e f).
pub struct Basis {
    /// n × 3 h.
    pub values: Mat<f64>,
    /// n × 2, in the plane of the sketch.
    pub places: Vec<[f64; 2]>,
    /// How a vertex moves in space by a unit along x and along y of the sketch's upload.
    pub axes: [[f64; 3]; 2],
}

/// The basis of a pose by handles, of the match and the weights of its results.
///
/// # Errors
/// [`PoseError`].
pub fn basis(
    sketch: &Sketch,
    mesh: &FileMesh,
    matched: &MatchResult,
    weights: &HandleWeights,
) -> Result<Basis, PoseError> {
    let seen = Seen::of(sketch, mesh, matched)?;
    let unasked = || Ok::<_, PoseError>(());
    let transfer = Transfer::new(sketch.mesh(), mesh.sound(), &seen.places, &seen.pairs, unasked)?;
    let handles = weights.values.first().map_or(0, Vec::len);
    let product = |v: usize, column: usize| {
        let [x, y] = sketch.point(v);
        let weight = weights.values.get(v).and_then(|row| row.get(column / 3)).copied().unwrap_or(0.0);
        weight * [x, y, 1.0][column % 3]
    };
    let carried = transfer.carried(&Mat::from_fn(sketch.mesh().positions().len(), 3 * handles, product), unasked)?;
    let beside = beside(mesh, &seen);
    // A vertex of no triangle stays where it is: all that moves it is 0.
    let value = |v: usize, column: usize| beside[v].as_ref().map_or(0.0, |beside| beside.value(&carried, column));
    let values = Mat::from_fn(beside.len(), 3 * handles, value);
    let places = beside.iter().map(|beside| beside.as_ref().map_or([0.0; 2], |beside| sketch.to_upload(beside.place)));
    let [right, up] = seen.axes();
    let [_, sign] = sketch.to_upload([0.0, 1.0]);
    Ok(Basis { values, places: places.collect(), axes: [right, up.map(|x| sign * x)] })
}
