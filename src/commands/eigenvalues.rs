//! `sketchmatch eigenvalues`: the spectrum of a mesh file beside what tells how exact it is.

use std::fs;
use std::path::PathBuf;

use anyhow::Context;
use clap::{Args, ValueEnum};
use faer::Mat;
use serde_json::json;
use sprs::CsMat;

use super::{printed, read};
use sketchmatch::mesh::connectivity::largest_component;
use sketchmatch::mesh::formats::{Format, Limits};
use sketchmatch::mesh::validation::import;
use sketchmatch::numerics::Unwatched;
use sketchmatch::spectral::laplacian::{self, stiffness};
use sketchmatch::spectral::{Boundary, Spectrum, spectrum_with};

#[derive(Debug, Args)]
pub struct EigenvaluesOptions {
    /// OBJ, OFF, PLY, STL, GLB or glTF.
    mesh: PathBuf,
    /// How many eigenvalues, the smallest first.
    #[arg(default_value_t = 100)]
    k: usize,
    /// The areas of the vertices.
    #[arg(long, env = "SKETCHMATCH_LUMPING", default_value = "mixed")]
    lumping: Lumping,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Lumping {
    /// Mixed Voronoi areas, as in a match.
    Mixed,
    /// A third of the triangles round a vertex, as other programs take.
    Barycentric,
}

impl From<Lumping> for laplacian::Lumping {
    fn from(lumping: Lumping) -> laplacian::Lumping {
        match lumping {
            Lumping::Mixed => laplacian::Lumping::Mixed,
            Lumping::Barycentric => laplacian::Lumping::Barycentric,
        }
    }
}

/// Prints the first k eigenvalues of a mesh's largest component as JSON, for comparison with other programs, with the
/// worst residual and the worst departure from orthonormality of the eigenfunctions, and (on Linux) the CPU seconds the
/// spectrum took.
///
/// # Errors
/// A file that is no mesh, or a mesh that has no such spectrum.
pub fn run(options: &EigenvaluesOptions) -> anyhow::Result<()> {
    let bytes = read(&options.mesh)?;
    let of_file = || options.mesh.display().to_string();
    let format = Format::sniff(&bytes).context("no mesh format is recognised").with_context(of_file)?;
    let mesh = import(&bytes, format, &Limits::default()).with_context(of_file)?.mesh;
    let mesh = largest_component(mesh.sound()).mesh;
    let before = cpu_seconds();
    let spectrum =
        spectrum_with(&mesh, options.lumping.into(), options.k, Boundary::Neumann, &Unwatched).with_context(of_file)?;
    let after = cpu_seconds();
    let report = json!({
        "vertices": spectrum.vertices(),
        "cpu_seconds": before.zip(after).map(|(before, after)| after - before),
        "eigenvalues": spectrum.eigenvalues,
        "worst_residual": worst_residual(&spectrum, &stiffness(&mesh)),
        "worst_orthonormality": worst_orthonormality(&spectrum),
    });
    printed(&report.to_string())
}

/// max ‖A^−½ (S φ − λ A φ)‖ / max(λ, 1), scaled to unit area.
fn worst_residual(spectrum: &Spectrum, stiffness: &CsMat<f64>) -> f64 {
    let (phi, mass, area) = (&spectrum.eigenfunctions, &spectrum.mass, spectrum.area());
    let residual = |j: usize| {
        let squared: f64 = stiffness
            .outer_iterator()
            .enumerate()
            .map(|(v, row)| {
                let image: f64 = row.iter().map(|(u, s)| s * phi[(u, j)]).sum();
                (image - spectrum.eigenvalues[j] * mass[v] * phi[(v, j)]).powi(2) / mass[v]
            })
            .sum();
        squared.sqrt() * area / (spectrum.eigenvalues[j] * area).max(1.0)
    };
    (0..spectrum.len()).map(residual).fold(0.0, f64::max)
}

/// max |Φᵀ A Φ − I|.
fn worst_orthonormality(spectrum: &Spectrum) -> f64 {
    let phi = &spectrum.eigenfunctions;
    let weighted = Mat::from_fn(phi.nrows(), phi.ncols(), |x, i| spectrum.mass[x] * phi[(x, i)]);
    (phi.transpose() * weighted - Mat::<f64>::identity(phi.ncols(), phi.ncols())).norm_max()
}

/// Time this thread has spent on a processor, where the kernel tells.
fn cpu_seconds() -> Option<f64> {
    let nanoseconds = fs::read_to_string("/proc/thread-self/schedstat").ok()?.split(' ').next()?.parse::<f64>();
    Some(1e-9 * nanoseconds.ok()?)
}
