//! How much memory a job takes: what would take more than there is for one is not queued. And how much an answer takes that is
//! made of what is stored.

use super::problem::Fault;
use crate::jobs::memory;
use crate::pipeline::Settings;
use crate::pipeline::settings::upsampled;
use crate::spectral::{RUNGS, rung};
use crate::store::Shape;

/// Bytes for each vertex of a shape and for each triangle: in its blob, in the mesh of the file, in the sound mesh, in the part
/// that is decomposed, and written.
const PER_VERTEX: usize = 256;
const PER_TRIANGLE: usize = 128;

/// Copies of a spectrum at one time: the blob and what is read of it; then that, the same at area 1, and what is worked on.
const COPIES_READ: usize = 3;

/// Copies of numbers that are answered: as they are computed, in the order of the file, as bytes, and in the file they make.
const COPIES_WRITTEN: usize = 4;

/// Bytes of functions in one answer.
pub const LARGEST_ANSWER: usize = 1 << 30;

/// The bytes it takes to read a shape and to answer by it, about.
pub fn of_shape(shape: &Shape) -> usize {
    shape.vertices.saturating_mul(PER_VERTEX).saturating_add(shape.triangles.saturating_mul(PER_TRIANGLE))
}

/// The bytes it takes to read a spectrum of at least `k` eigenpairs at these many vertices and to work on it, about.
pub fn of_kept_spectrum(vertices: usize, k: usize) -> usize {
    rung(k).saturating_mul(COPIES_READ * size_of::<f64>()).saturating_mul(vertices)
}

/// The bytes it takes to answer so many numbers at each of these vertices, about.
pub fn of_numbers(vertices: usize, numbers: usize) -> usize {
    numbers.saturating_mul(COPIES_WRITTEN * size_of::<f64>()).saturating_mul(vertices)
}

/// The bytes a spectrum of at least `k` eigenpairs takes at its peak, about, on a shape of these many vertices.
pub fn of_spectrum(vertices: usize, k: usize) -> usize {
    memory::of_spectrum(k).saturating_mul(vertices)
}

/// The bytes it takes to pose a mesh of these many vertices, about.
pub fn of_pose(vertices: usize) -> usize {
    memory::of_pose().saturating_mul(vertices)
}

/// What is wrong with posing a mesh of these many vertices with `budget` bytes.
pub fn excess_of_pose(vertices: usize, budget: usize) -> Option<String> {
    let needed = of_pose(vertices);
    (needed > budget).then(|| {
        let (needed, most) = (needed.div_ceil(1 << 20), budget >> 20);
        format!("posing a mesh of {vertices} vertices takes about {needed} MiB, a job may take {most} MiB")
    })
}

/// What is wrong with asking for `k` eigenpairs of a shape of these many vertices with `budget` bytes.
pub fn excess(vertices: usize, k: usize, budget: usize) -> Option<String> {
    let needed = of_spectrum(vertices, k);
    let most = RUNGS.into_iter().rev().find(|&rung| of_spectrum(vertices, rung) <= budget);
    let remedy = most.map_or("no number of them fits".to_owned(), |most| format!("up to {most} fit"));
    (needed > budget).then(|| {
        let mebibytes = |bytes: usize| bytes.div_ceil(1 << 20);
        format!(
            "{k} eigenpairs of {vertices} vertices take about {} MiB, a job may take {} MiB: {remedy}",
            mebibytes(needed),
            budget >> 20
        )
    })
}

/// The spectra that settings need and a job of `budget` bytes cannot have, on shapes of these many vertices; or the map, where
/// there is no room for it beside them.
pub fn faults(settings: &Settings, sketch_vertices: usize, mesh_vertices: usize, budget: usize) -> Vec<Fault> {
    let (basis, (k, l)) = (&settings.basis, upsampled(settings));
    let refined = (k, l) != (basis.k, basis.k_mesh);
    let of_basis = ["/basis/k", "/basis/k_mesh"];
    let spectra = [(sketch_vertices, k), (mesh_vertices, l)].into_iter().zip(of_basis);
    let faults: Vec<Fault> = spectra
        .filter_map(|((vertices, k), pointer)| {
            Some(Fault::at_pointer(if refined { "/refinement/k" } else { pointer }, excess(vertices, k, budget)?))
        })
        .collect();
    let (of_map, of_spectra) =
        (memory::of_map(settings), of_spectrum(sketch_vertices, k).max(of_spectrum(mesh_vertices, l)));
    if !faults.is_empty() || of_map.saturating_add(of_spectra) <= budget {
        return faults;
    }
    let pointer = if settings.terms.is_empty() { "/basis" } else { "/terms" };
    let detail = format!(
        "a map of {} × {} with {} terms takes about {} MiB beside the spectra, a job may take {} MiB with them",
        basis.k_mesh,
        basis.k,
        settings.terms.len(),
        of_map.div_ceil(1 << 20),
        budget >> 20
    );
    vec![Fault::at_pointer(pointer, detail)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::request::{MatchRequest, Preset};

    const GIB: usize = 1 << 30;

    #[test]
    fn a_spectrum_takes_what_its_rung_takes() {
        assert_eq!(of_spectrum(1000, 20), 1000 * ((6 * 20 + 224) * 8 + 2048));
        assert_eq!(of_spectrum(1000, 7), of_spectrum(1000, 20));
        assert_eq!(of_spectrum(usize::MAX, usize::MAX), usize::MAX);
    }

    #[test]
    fn what_is_answered_takes_what_its_copies_take() {
        assert_eq!(of_kept_spectrum(1000, 7), 1000 * 20 * 8 * 3);
        assert_eq!(of_numbers(1000, 7), 1000 * 7 * 8 * 4);
        assert_eq!((of_kept_spectrum(usize::MAX, 7), of_numbers(2, usize::MAX)), (usize::MAX, usize::MAX));
    }

    #[test]
    fn a_pose_takes_more_the_larger_the_mesh_is() {
        assert_eq!(excess_of_pose(500_000, 8 * GIB), None);
        assert!(excess_of_pose(2_000_000, 8 * GIB).unwrap().contains("of 2000000 vertices"));
        assert_eq!(of_pose(usize::MAX), usize::MAX);
    }

    #[test]
    fn what_fits_is_said_and_asking_for_it_is_accepted() {
        let refusal = excess(500_000, 500, 8 * GIB).unwrap();
        assert!(refusal.ends_with("up to 250 fit"), "{refusal}");
        assert_eq!(excess(500_000, 250, 8 * GIB), None);
        assert!(excess(500_000, 1, GIB).unwrap().ends_with("no number of them fits"));
    }

    #[test]
    fn faults_name_the_number_that_is_too_large() {
        let request = |text: &str| serde_json::from_str::<MatchRequest>(text).unwrap();
        let pointers = |text: &str| {
            let settings = Settings::resolve(&request(text)).unwrap();
            let faults = faults(&settings, 800, 500_000, 3 * GIB);
            faults.into_iter().filter_map(|fault| fault.pointer).collect::<Vec<_>>()
        };
        let preset = serde_json::to_string(&Preset::Thesis).unwrap();
        let with = |rest: &str| format!(r#"{{"mesh": "m", "sketch": "s", "preset": {preset}{rest}}}"#);
        assert!(pointers(&with("")).is_empty());
        assert_eq!(pointers(&with(r#", "basis": {"k": 20, "k_mesh": 60}"#)), ["/basis/k_mesh"]);
        assert_eq!(pointers(&with(r#", "refinement": {"method": "zoomout", "k": 60}"#)), ["/refinement/k"]);
        let of_terms = |count: usize| {
            let terms = vec![r#"{"type": "descriptors"}"#; count].join(", ");
            let request = format!(r#"{{"mesh": "m", "sketch": "s", "basis": {{"k": 500}}, "terms": [{terms}]}}"#);
            let settings = Settings::resolve(&serde_json::from_str::<MatchRequest>(&request).unwrap()).unwrap();
            let faults = faults(&settings, 800, 5_000, GIB / 2);
            faults.into_iter().filter_map(|fault| fault.pointer).collect::<Vec<_>>()
        };
        assert_eq!((of_terms(1), of_terms(8)), (vec![], vec!["/terms".to_owned()]));
    }
}
