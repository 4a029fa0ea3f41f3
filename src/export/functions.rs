//! Functions, regions and rebuilt places of a shape, for the vertices of its file.

use bytes::Bytes;
use faer::Mat;
use safetensors::tensor::{Dtype, TensorView};

use super::{Unwritten, npy};
use crate::mesh::figure::Figure;
use crate::mesh::file_mesh::FileMesh;
use crate::mesh::followers::{Follower, followers};
use crate::picture::paint::Paint;
use crate::picture::{painted_glb, painted_png, posed_glb};
use crate::regions::Regions;

/// Values by rows, one per vertex of the file; not a number where a vertex is none of the figure's.
fn rows(values: &Mat<f64>, figure: &Figure) -> Vec<f64> {
    let columns = values.ncols();
    figure.of_file().flat_map(|row| (0..columns).map(move |j| row.map_or(f64::NAN, |row| values[(row, j)]))).collect()
}

/// Functions as an array, a row per vertex of the file.
pub fn npy(values: &Mat<f64>, figure: &Figure) -> Bytes {
    npy::file(figure.of_file().len(), values.ncols(), rows(values, figure)).into()
}

/// The same as `values` in one file of safetensors.
///
/// # Errors
/// What the encoder reports.
pub fn safetensors(values: &Mat<f64>, figure: &Figure) -> Result<Bytes, Unwritten> {
    let bytes: Vec<u8> = rows(values, figure).into_iter().flat_map(f64::to_le_bytes).collect();
    let shape = vec![figure.of_file().len(), values.ncols()];
    Ok(safetensors::serialize([("values", TensorView::new(Dtype::F64, shape, &bytes)?)], None)?.into())
}

/// The first of functions as colours of the shape, red above 0 and blue below, or from white at the least.
///
/// # Errors
/// What the encoder reports.
pub fn glb(values: &Mat<f64>, figure: &Figure, mesh: &FileMesh) -> Result<Bytes, Unwritten> {
    Ok(painted_glb(mesh, &Paint::Values(&rows(values, figure)))?.into())
}

/// The same as a picture.
///
/// # Errors
/// What the encoder reports.
pub fn png(values: &Mat<f64>, figure: &Figure, mesh: &FileMesh, width: u32) -> Result<Bytes, Unwritten> {
    Ok(painted_png(mesh, &Paint::Values(&rows(values, figure)), width)?.into())
}

/// The label of every vertex of the file, −1 where it is in no region.
pub fn labels(regions: &Regions, figure: &Figure) -> Vec<i32> {
    figure.of_file().map(|row| row.map_or(Regions::NONE, |row| regions.labels()[row])).collect()
}

/// Regions as colours of the shape.
///
/// # Errors
/// What the encoder reports.
pub fn labelled_glb(labels: &[i32], mesh: &FileMesh) -> Result<Bytes, Unwritten> {
    Ok(painted_glb(mesh, &Paint::Labels(labels))?.into())
}

/// The same as a picture.
///
/// # Errors
/// What the encoder reports.
pub fn labelled_png(labels: &[i32], mesh: &FileMesh, width: u32) -> Result<Bytes, Unwritten> {
    Ok(painted_png(mesh, &Paint::Labels(labels), width)?.into())
}

/// Where the vertices of a file are that has its figure's at these places: as far from those of the figure that answer for them as
/// ever; its own where they are none of those.
pub fn placed(places: &[[f64; 3]], figure: &Figure, mesh: &FileMesh) -> Vec<[f64; 3]> {
    let followers = followers(&figure.mesh, mesh.positions(), figure.of_file());
    let placed = |(follower, &own): (Option<Follower>, &[f64; 3])| {
        let Some(follower) = follower else { return own };
        let [was, now] = [figure.mesh.positions(), places].map(|places| follower.blended(|v| places[v]));
        std::array::from_fn(|i| now[i] + (own[i] - was[i]))
    };
    followers.zip(mesh.positions()).map(placed).collect()
}

/// Places as an array, a row per vertex of the file.
pub fn places_npy(places: &[[f64; 3]]) -> Bytes {
    npy::file(places.len(), 3, places.as_flattened().iter().copied()).into()
}

/// The shape with its vertices at these places, as glTF 2.0 binary.
///
/// # Errors
/// What the encoder reports.
pub fn places_glb(places: Vec<[f64; 3]>, mesh: &FileMesh) -> Result<Bytes, Unwritten> {
    Ok(posed_glb(mesh, &[places])?.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::formats::{Format, Limits};
    use crate::mesh::solids::sphere;
    use crate::mesh::validation::import;

    #[test]
    fn a_file_of_many_triangles_keeps_them_apart() {
        let ball = sphere(20, 40);
        let vertices = ball.positions().iter().map(|[x, y, z]| format!("v {x} {y} {z}\n"));
        let faces = ball.triangles().iter().map(|t| t.map(|v| v + 1)).map(|[a, b, c]| format!("f {a} {b} {c}\n"));
        let obj: String = vertices.chain(faces).collect();
        let limits = Limits { triangles: 500, ..Limits::default() };
        let mesh = import(obj.as_bytes(), Format::Obj, &limits).unwrap().mesh;
        assert!(mesh.is_decimated());
        let figure = Figure::largest(&mesh);
        let shifted: Vec<[f64; 3]> = figure.mesh.positions().iter().map(|[x, y, z]| [x + 1.0, *y, *z]).collect();
        for (placed, [x, y, z]) in placed(&shifted, &figure, &mesh).into_iter().zip(mesh.positions()) {
            assert!(placed.into_iter().zip([x + 1.0, *y, *z]).all(|(a, b)| (a - b).abs() < 1e-12));
        }
    }
}
