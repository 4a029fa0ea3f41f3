//! The example creatures: implicit bodies made by code, a view of each, and the true correspondence of the two.
//!
//! Meshes are in metres or thereabouts: x to the creature's left, y up, z forwards.

mod anatomy;
mod body;
pub mod drawing;
mod silhouette;
mod surface;
mod truth;
mod view;

use std::fmt::Write;
use std::ops::RangeInclusive;

pub use silhouette::Silhouette;
pub use view::View;

use crate::evaluation::truth::Truth;
use crate::mesh::TriangleMesh;
use crate::mesh::refusal::Refusal;
use body::Body;

/// The sizes a creature can be meshed at, in vertices.
pub const SIZES: RangeInclusive<usize> = 2_000..=100_000;

/// The vertices a creature has where nobody asks for others.
pub const VERTICES: usize = 5_000;

/// A creature to match.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Creature {
    /// A cat in mid-stride, drawn from its left.
    Quadruped,
    /// A standing person, drawn from the front.
    Biped,
}

/// Why an example could not be made.
#[derive(Debug, thiserror::Error)]
pub enum Unmade {
    #[error("the mesh of the creature is not valid: {0}")]
    Mesh(#[from] Refusal),
    #[error("the creature cannot be seen")]
    Unseen,
    #[error("the picture cannot be encoded: {0}")]
    Picture(#[from] image::ImageError),
}

impl Creature {
    pub const ALL: [Self; 2] = [Self::Quadruped, Self::Biped];

    /// The name of its folder.
    pub fn name(self) -> &'static str {
        match self {
            Self::Quadruped => "quadruped",
            Self::Biped => "biped",
        }
    }

    /// What it is, in words.
    pub fn description(self) -> &'static str {
        match self {
            Self::Quadruped => "a cat in mid-stride, drawn from its left",
            Self::Biped => "a standing person, drawn from the front",
        }
    }

    /// The view it is drawn from.
    pub fn view(self) -> View {
        match self {
            Self::Quadruped => View::Side,
            Self::Biped => View::Front,
        }
    }

    /// Its surface: closed, connected, of genus 0, wound outwards. Its number of vertices is within a tenth of
    /// `vertices`, which is taken into [`SIZES`].
    ///
    /// # Errors
    /// [`Unmade::Mesh`] where the surface is not a valid mesh.
    pub fn mesh(self, vertices: usize) -> Result<TriangleMesh, Unmade> {
        let (positions, triangles) = surface::triangles(&self.body(), vertices.clamp(*SIZES.start(), *SIZES.end()));
        Ok(TriangleMesh::new(positions, triangles)?)
    }

    /// The silhouette of its mesh in its view.
    ///
    /// # Errors
    /// [`Unmade::Unseen`] where no triangle of the mesh faces the viewer.
    pub fn silhouette(self, mesh: &TriangleMesh) -> Result<Silhouette, Unmade> {
        Silhouette::of(mesh, self.view()).ok_or(Unmade::Unseen)
    }

    /// The true vertices of its mesh for a dense set of points of its silhouette.
    pub fn truth(self, mesh: &TriangleMesh, silhouette: &Silhouette) -> Truth {
        truth::truth(&self.body(), mesh, silhouette, self.view())
    }

    fn body(self) -> Body {
        match self {
            Self::Quadruped => anatomy::quadruped(),
            Self::Biped => anatomy::biped(),
        }
    }
}

/// Names and contents of the example's files: for either creature, its mesh of about `vertices` vertices and the sketch
/// of it as `NAME/mesh.obj`, `NAME/sketch.json`, `NAME/sketch.svg`, `NAME/sketch.png` and `NAME/truth.json`.
///
/// # Errors
/// [`Unmade`], for the first thing that could not be made.
pub fn files(vertices: usize) -> Result<Vec<(String, Vec<u8>)>, Unmade> {
    let mut files = Vec::new();
    for creature in Creature::ALL {
        let mesh = creature.mesh(vertices)?;
        let silhouette = creature.silhouette(&mesh)?;
        let truth = creature.truth(&mesh, &silhouette);
        let contents = [
            ("mesh.obj", obj(&mesh).into_bytes()),
            ("sketch.json", drawing::json(&silhouette).into_bytes()),
            ("sketch.svg", drawing::svg(&silhouette).into_bytes()),
            ("sketch.png", drawing::png(&silhouette)?),
            ("truth.json", serde_json::json!(truth).to_string().into_bytes()),
        ];
        files.extend(contents.map(|(file, bytes)| (format!("{}/{file}", creature.name()), bytes)));
    }
    Ok(files)
}

/// The mesh as Wavefront OBJ, its vertices in their order.
pub fn obj(mesh: &TriangleMesh) -> String {
    let mut text = String::new();
    for [x, y, z] in mesh.positions() {
        // Writing to a string cannot fail.
        let _ = writeln!(text, "v {x:.6} {y:.6} {z:.6}");
    }
    for [a, b, c] in mesh.triangles().iter().map(|t| t.map(|v| v + 1)) {
        let _ = writeln!(text, "f {a} {b} {c}");
    }
    text
}

#[cfg(test)]
mod tests;
