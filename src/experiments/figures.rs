//! Figures of the thesis that show shapes: eigenfunctions (figs. 2.1 and 2.2), a shape rebuilt of them (fig. 2.3), and pairs in matching
//! colours (figs. 4.1, 5.1, A.1 to A.3).

use serde_json::json;

use super::chapter4::File;
use super::matrix::{Matrix, Unfit, combinations};
use super::run::{Case, Unrun, answers};
use crate::export::Unwritten;
use crate::export::picture::{Form, Look, file as picture};
use crate::mesh::TriangleMesh;
use crate::mesh::file_mesh::FileMesh;
use crate::mesh::refusal::Refusal;
use crate::numerics::Unwatched;
use crate::picture::gallery_png;
use crate::picture::paint::Paint;
use crate::sketch::outline::OutlineRequest;
use crate::sketch::{self, Sketch};
use crate::spectral::rebuilt::rebuilt;
use crate::spectral::{Boundary, SpectralError, spectrum};

/// Eigenfunctions shown of either shape, beside each other.
const SHOWN: usize = 8;
/// Vertices of the square and of that with a tail, about.
const VERTICES: usize = 2000;
/// A square, and one with a tail.
const SQUARE: [[f64; 2]; 4] = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]];
const WITH_TAIL: [[f64; 2]; 8] =
    [[0.0, 0.0], [10.0, 0.0], [10.0, 4.0], [15.0, 4.0], [15.0, 6.0], [10.0, 6.0], [10.0, 10.0], [0.0, 10.0]];
/// Eigenfunctions that a shape is rebuilt of.
const REBUILT: [usize; 5] = [10, 30, 100, 300, 500];
/// The width of a shape in the figures, in pixels.
const WIDTH: u32 = 240;
/// Cases shown as pairs at most.
const PAIRS: usize = 12;

/// Why a figure cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum Undrawn {
    #[error(transparent)]
    Flat(#[from] sketch::Refusal),
    #[error(transparent)]
    Shape(#[from] Refusal),
    #[error(transparent)]
    Spectrum(#[from] SpectralError),
    #[error(transparent)]
    Unwritten(#[from] Unwritten),
    #[error(transparent)]
    Unrun(#[from] Unrun),
    #[error(transparent)]
    Unfit(#[from] Unfit),
}

/// Figs. 2.1 and 2.2: the first eigenfunctions, but for the constant one, of a square above and of a square with a tail below,
/// where they are 0 at the boundary (Dirichlet) and where nothing flows over it (Neumann).
///
/// # Errors
/// [`Undrawn`].
pub fn eigenfunctions() -> Result<Vec<File>, Undrawn> {
    let shapes = [flat(&SQUARE)?, flat(&WITH_TAIL)?];
    let mut files = Vec::new();
    for (boundary, name) in [(Boundary::Dirichlet, "dirichlet"), (Boundary::Neumann, "neumann")] {
        let constants = if boundary == Boundary::Neumann { 1 } else { 0 };
        let mut functions = Vec::new();
        for shape in &shapes {
            let spectrum = spectrum(shape.mesh(), SHOWN + constants, boundary, &Unwatched)?;
            let of = |i: usize| spectrum.eigenfunctions.col(i).iter().copied().collect::<Vec<f64>>();
            functions.push((
                FileMesh::from(shape.mesh().clone()),
                (constants..SHOWN + constants).map(of).collect::<Vec<_>>(),
            ));
        }
        let painted: Vec<(&FileMesh, Paint<'_>)> = functions
            .iter()
            .flat_map(|(mesh, values)| values.iter().map(move |values| (mesh, Paint::Values(values))))
            .collect();
        files.push((
            format!("eigenfunctions_{name}.png"),
            gallery_png(&painted, SHOWN, WIDTH).map_err(Unwritten::from)?,
        ));
    }
    Ok(files)
}

/// The figure within an outline.
fn flat(outline: &[[f64; 2]]) -> Result<Sketch, sketch::Refusal> {
    let request = OutlineRequest { outline: outline.to_vec(), holes: Vec::new(), target_vertices: Some(VERTICES) };
    let (drawing, vertices) = request.into_parts();
    Ok(sketch::from_outline(&drawing, vertices, &sketch::Config::default())?.sketch)
}

/// Fig. 2.3: a mesh of which the coordinates are rebuilt of its first eigenfunctions, more from left to right, and the mesh itself.
///
/// # Errors
/// [`Undrawn`].
pub fn rebuilding(mesh: &FileMesh) -> Result<File, Undrawn> {
    let sound = mesh.sound();
    let most = REBUILT.into_iter().filter(|&k| k < sound.positions().len()).max().unwrap_or(1);
    let spectrum = spectrum(sound, most, Boundary::Neumann, &Unwatched)?;
    let of_places = |places| TriangleMesh::new(places, sound.triangles().to_vec()).map(FileMesh::from);
    let mut shapes = Vec::new();
    for k in REBUILT.into_iter().filter(|&k| k <= most) {
        shapes.push(of_places(rebuilt(&spectrum.at_unit_area(k), sound.positions()))?);
    }
    shapes.push(FileMesh::from(sound.clone()));
    let plain = vec![Some([0.9; 3]); sound.positions().len()];
    let painted: Vec<(&FileMesh, Paint<'_>)> = shapes.iter().map(|shape| (shape, Paint::Colours(&plain))).collect();
    let columns = painted.len();
    Ok(("rebuilt.png".to_owned(), gallery_png(&painted, columns, WIDTH).map_err(Unwritten::from)?))
}

/// Figs. 4.1 and A.1 to A.3, by the method of the thesis with regions of the truth, and fig. 5.1, by the automatic one: the
/// drawing and the mesh of the first cases in matching colours.
///
/// # Errors
/// [`Undrawn`].
pub fn pairs(cases: &[Case]) -> Result<Vec<File>, Undrawn> {
    let requests: Matrix = serde_json::from_value(json!([{
        "automatic": {},
        "thesis": {"preset": "thesis", "regions": {"method": "truth", "count": 7}, "conversion": {"method": "nearest"}},
    }]))
    .unwrap_or_default();
    let cases = &cases[..cases.len().min(PAIRS)];
    let mut files = Vec::new();
    let requests = combinations(&requests)?;
    for (combination, answers) in requests.iter().zip(answers(&requests, cases)?) {
        for (case, answer) in cases.iter().zip(answers) {
            let Some(mut answer) = answer else { continue };
            // In full colours, however sure: what is shown is what came of each point.
            answer.correspondences.iter_mut().for_each(|point| point.confidence = 1.0);
            let result = serde_json::to_vec(&answer).map_err(Unwritten::from)?;
            let bytes = picture(Look::from(Form::Png), &result, &case.sketch, &case.mesh)?;
            files.push((format!("pair_{}_{}.png", case.name, combination.name()), bytes));
        }
    }
    Ok(files)
}
