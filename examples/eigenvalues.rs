//! Prints the first k eigenvalues of a mesh file as JSON, for comparison with other programs, with the worst residual
//! and the worst departure from orthonormality of the eigenfunctions, and (on Linux) the CPU seconds the spectrum took:
//!
//!     cargo run --release --example eigenvalues -- MESH [K] [mixed|barycentric]

use std::error::Error;

use sketchmatch::mesh::connectivity::largest_component;
use sketchmatch::mesh::formats::{Format, Limits};
use sketchmatch::mesh::validation::import;
use sketchmatch::numerics::Unwatched;
use sketchmatch::spectral::laplacian::{Lumping, stiffness};
use sketchmatch::spectral::{Boundary, Spectrum, spectrum_with};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let path = arguments.first().ok_or("usage: eigenvalues MESH [K] [mixed|barycentric]")?;
    let k = arguments.get(1).map_or(Ok(100), |k| k.parse())?;
    let lumping = match arguments.get(2).map(String::as_str) {
        None | Some("mixed") => Lumping::Mixed,
        Some("barycentric") => Lumping::Barycentric,
        Some(other) => return Err(format!("no lumping is called {other}").into()),
    };
    let bytes = std::fs::read(path)?;
    let format = Format::sniff(&bytes).ok_or("not a mesh")?;
    let mesh = largest_component(&import(&bytes, format, &Limits::default())?.mesh.sound()).mesh;
    let before = cpu_seconds();
    let spectrum = spectrum_with(&mesh, lumping, k, Boundary::Neumann, &Unwatched)?;
    let after = cpu_seconds();
    let report = serde_json::json!({
        "vertices": spectrum.vertices(),
        "cpu_seconds": before.zip(after).map(|(before, after)| after - before),
        "eigenvalues": spectrum.eigenvalues,
        "worst_residual": worst_residual(&spectrum, &stiffness(&mesh)),
        "worst_orthonormality": worst_orthonormality(&spectrum),
    });
    println!("{report}");
    Ok(())
}

/// max ‖A^−½ (S φ − λ A φ)‖ / max(λ, 1), scaled to unit area.
fn worst_residual(spectrum: &Spectrum, stiffness: &sprs::CsMat<f64>) -> f64 {
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
    let weighted = faer::Mat::from_fn(phi.nrows(), phi.ncols(), |x, i| spectrum.mass[x] * phi[(x, i)]);
    (phi.transpose() * weighted - faer::Mat::<f64>::identity(phi.ncols(), phi.ncols())).norm_max()
}

/// Time this thread has spent on a processor, where the kernel tells.
fn cpu_seconds() -> Option<f64> {
    let nanoseconds = std::fs::read_to_string("/proc/thread-self/schedstat").ok()?.split(' ').next()?.parse::<f64>();
    Some(1e-9 * nanoseconds.ok()?)
}
