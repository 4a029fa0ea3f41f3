//! A match as a picture, and the mesh in the colours of the sketch.

use serde::Deserialize;

use super::Unwritten;
use crate::geometry::cross;
use crate::geometry::frame::Frame;
use crate::mesh::file_mesh::FileMesh;
use crate::picture::{self, Matched, WIDTH};
use crate::pipeline::outcome::ViewReport;
use crate::sketch::Sketch;

/// What a picture of a match is a file of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Form {
    Png,
    Svg,
    /// The mesh alone, in space.
    Glb,
}

/// How a picture of a match is to be.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    pub form: Form,
    /// In pixels; of no meaning in space.
    pub width: u32,
    /// Which alternative is shown instead of the answer.
    pub alternative: Option<usize>,
}

impl From<Form> for Look {
    /// The answer in this form, of the usual width.
    fn from(form: Form) -> Look {
        Look { form, width: WIDTH, alternative: None }
    }
}

/// What a picture needs of a result.
#[derive(Deserialize)]
struct Seen {
    correspondences: Vec<Point>,
    alignment: Option<Aligned>,
    alternatives: Vec<Alternative>,
}

#[derive(Deserialize)]
struct Point {
    mesh_vertex: u32,
    /// Nothing where it is not known.
    confidence: Option<f64>,
}

#[derive(Deserialize)]
struct Aligned {
    view: ViewReport,
}

#[derive(Deserialize)]
struct Alternative {
    view: ViewReport,
    mesh_vertices: Vec<u32>,
}

impl Seen {
    /// The result as if an alternative were its answer; its points are believed as those of the answer.
    fn instead(mut self, alternative: usize) -> Option<Seen> {
        let Alternative { view, mesh_vertices } = self.alternatives.drain(..).nth(alternative)?;
        self.correspondences.iter_mut().zip(mesh_vertices).for_each(|(point, vertex)| point.mesh_vertex = vertex);
        Some(Seen { alignment: Some(Aligned { view }), ..self })
    }
}

/// A file with a picture of the result, as the service wrote it, of a match of these two shapes.
///
/// # Errors
/// A result that cannot be read, is of other shapes or has no such alternative; what an encoder reports.
pub fn file(look: Look, result: &[u8], sketch: &Sketch, mesh: &FileMesh) -> Result<Vec<u8>, Unwritten> {
    let seen: Seen = serde_json::from_slice(result)?;
    let seen = match look.alternative {
        Some(alternative) => seen.instead(alternative).ok_or(Unwritten::NoAlternative)?,
        None => seen,
    };
    let pair = matched(seen, sketch, mesh)?;
    Ok(match look.form {
        Form::Png => picture::png(&pair, look.width)?,
        Form::Svg => picture::svg(&pair, look.width)?.into_bytes(),
        Form::Glb => picture::glb(&pair, mesh)?,
    })
}

/// The match of these two shapes that a result tells of, as the service wrote it.
///
/// # Errors
/// A result that cannot be read or is of other shapes.
pub(super) fn pair<'a>(result: &[u8], sketch: &'a Sketch, mesh: &'a FileMesh) -> Result<Matched<'a>, Unwritten> {
    matched(serde_json::from_slice(result)?, sketch, mesh)
}

fn matched<'a>(seen: Seen, sketch: &'a Sketch, mesh: &'a FileMesh) -> Result<Matched<'a>, Unwritten> {
    let view = seen.alignment.map(|Aligned { view: ViewReport { toward_camera, up } }| Frame {
        right: cross(up, toward_camera),
        up,
        toward_camera,
    });
    let points = seen.correspondences.into_iter();
    let points = points.map(|Point { mesh_vertex, confidence }| {
        // Where there is no such vertex this is one past the last, and refused.
        let vertex = mesh.sound_vertices(mesh_vertex).next().unwrap_or(mesh.sound().positions().len() as u32);
        (vertex, confidence.unwrap_or(0.0))
    });
    Ok(Matched::new(sketch, mesh.sound(), points, view)?)
}
