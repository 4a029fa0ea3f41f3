//! What is wrong with settings: by themselves, and for the shapes.

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::{Basis, Descriptors, Settings, upsampled};
use crate::functional_map::regulariser::Regulariser;
use crate::functional_map::weights;
use crate::pipeline::Fault;
use crate::pipeline::request::{
    Alignment, Conversion, Coupling, Direction, FunctionPair, GivenMap, Part, Refinement, Regions, Ups,
};
use crate::regions::{LabelOutOfRange, MAX_REGIONS};

/// The most eigenfunctions of a basis.
const MAX_BASIS: usize = 500;
/// The most components of the heat kernel signature, and of the wave kernel signature.
pub const MAX_SIGNATURE: usize = 1000;
const MAX_LANDMARKS: usize = 1000;
/// Widths of a band of energy in spacings of the energies; in a narrower one there is no room for rounding.
const VARIANCES: std::ops::RangeInclusive<f64> = 1e-6..=1e6;
/// The most components of a mesh that a request names.
const MAX_COMPONENTS: usize = 10_000;
const MAX_ICP: usize = 200;
const MAX_TERMS: usize = 8;
const MAX_FUNCTIONS: usize = 1000;
/// The largest magnitude of a number in a map or a function that is given. Energies are squares of a map times a function: times
/// all weights and counts there are they stay far from overflow, which JSON has no number for.
const LARGEST_NUMBER: f64 = 1e50;

/// Faults as they are found.
#[derive(Default)]
struct Faults(Vec<Fault>);

impl Faults {
    fn add(&mut self, pointer: impl Into<String>, detail: impl Into<String>) {
        self.0.push(Fault { pointer: pointer.into(), detail: detail.into() });
    }

    fn range(&mut self, pointer: &str, value: usize, least: usize, most: usize) {
        if !(least..=most).contains(&value) {
            self.add(pointer, format!("must be {least} to {most}, is {value}"));
        }
    }

    /// A list that has not one entry for each of these.
    fn counted(&mut self, pointer: impl Into<String>, entry: &str, found: usize, wanted: usize, each: &str) {
        if found != wanted {
            self.add(pointer, format!("must have {entry} for each of the {wanted} {each}, has {found}"));
        }
    }

    /// The first of the numbers that is too large.
    fn numbers(&mut self, pointer: &str, numbers: &[f64]) {
        if let Some((i, detail)) = too_large(numbers) {
            self.add(format!("{pointer}/{i}"), detail);
        }
    }
}

impl Settings {
    /// Every value out of its range.
    pub(super) fn faults(&self) -> Vec<Fault> {
        let mut faults = Faults::default();
        self.basis_faults(&mut faults);
        self.descriptor_faults(&mut faults);
        if let Some(components) = &self.components {
            faults.range("/components", components.len(), 1, MAX_COMPONENTS);
        }
        self.region_faults(&mut faults);
        self.alignment_faults(&mut faults);
        if self.landmarks.len() > MAX_LANDMARKS {
            faults.add("/landmarks", format!("must be at most {MAX_LANDMARKS}"));
        }
        self.given_faults(&mut faults);
        self.energy_faults(&mut faults);
        self.refinement_faults(&mut faults);
        faults.0
    }

    fn basis_faults(&self, faults: &mut Faults) {
        faults.range("/basis/k", self.basis.k, 1, MAX_BASIS);
        faults.range("/basis/k_mesh", self.basis.k_mesh, 1, MAX_BASIS);
        if let Coupling::JointDiagonalisation { weight } = self.basis.coupling {
            if !(weight > 0.0 && weight <= 1e6) {
                faults.add("/basis/coupling/weight", format!("must be above 0 and at most 1000000, is {weight:?}"));
            }
            if self.basis.k != self.basis.k_mesh {
                faults.add("/basis/coupling", "needs as many eigenfunctions of either shape: basis.k and basis.k_mesh");
            }
            if matches!(self.regulariser, Regulariser::PermutedL1(_)) {
                faults.add("/basis/coupling", "needs regions in a known order: permuted_l1 has none");
            }
            if matches!(self.regulariser, Regulariser::PartIndicator(_)) {
                faults.add("/basis/coupling", "needs functions of the whole mesh: part_indicator finds a part of it");
            }
        }
    }

    fn descriptor_faults(&self, faults: &mut Faults) {
        let Descriptors { hks, wks, .. } = &self.descriptors;
        faults.range("/descriptors/hks/count", hks.count, 0, MAX_SIGNATURE);
        if let Some([first, last]) = hks.times
            && !(first >= 1e-12 && first <= last && last <= 1e12)
        {
            faults.add("/descriptors/hks/times", "must be two times in ascending order, from 1e-12 to 1e12");
        }
        faults.range("/descriptors/wks/count", wks.count, 0, MAX_SIGNATURE);
        if !VARIANCES.contains(&wks.variance) {
            let (least, most) = (VARIANCES.start(), VARIANCES.end());
            faults.add("/descriptors/wks/variance", format!("must be {least} to {most}, is {:?}", wks.variance));
        }
    }

    fn region_faults(&self, faults: &mut Faults) {
        match &self.regions {
            Regions::Auto { count } => faults.range("/regions/count", *count, 1, MAX_REGIONS),
            Regions::Given { sketch, mesh } => {
                let occurring = [("sketch", sketch), ("mesh", mesh)].map(|(name, labels)| {
                    labels_occurring(labels).unwrap_or_else(|error| {
                        faults.add(format!("/regions/{name}/{}", error.vertex), error.to_string());
                        u64::MAX
                    })
                });
                if occurring[0] & occurring[1] == 0 {
                    faults.add("/regions", "no label occurs on both shapes");
                }
            }
            Regions::Segmented { sketch_regions, mesh_regions, pairs } => {
                faults.range("/regions/sketch_regions", *sketch_regions, 1, MAX_REGIONS);
                faults.range("/regions/mesh_regions", *mesh_regions, 1, MAX_REGIONS);
                if pairs.is_empty() || pairs.len() > MAX_REGIONS {
                    faults.add("/regions/pairs", format!("must be 1 to {MAX_REGIONS} pairs"));
                    return;
                }
                for (i, pair) in pairs.iter().enumerate() {
                    for (side, (shape, other)) in [("sketch", "mesh"), ("mesh", "sketch")].into_iter().enumerate() {
                        let earlier = pairs[..i].iter().position(|earlier| earlier[side] == pair[side]);
                        if let Some(earlier) = earlier {
                            let detail = format!(
                                "region {} of the {shape} has its region of the {other} in pair {earlier} already",
                                pair[side]
                            );
                            faults.add(format!("/regions/pairs/{i}/{side}"), detail);
                        }
                    }
                    for (side, (region, count)) in pair.iter().zip([sketch_regions, mesh_regions]).enumerate() {
                        if region >= count {
                            faults.add(format!("/regions/pairs/{i}/{side}"), format!("must be below {count}"));
                        }
                    }
                }
            }
        }
    }

    fn alignment_faults(&self, faults: &mut Faults) {
        if self.up != Ups::default() && self.alignment == (Alignment::None {}) {
            faults.add("/up", "matters to an alignment of views only, and none is asked for");
        }
        let directions = [self.up.sketch.as_ref().map(coordinates), self.up.mesh.as_ref().map(coordinates)];
        for (shape, coordinates) in ["sketch", "mesh"].into_iter().zip(directions) {
            if let Some(Some(x)) = coordinates
                && !(x.iter().all(|x| x.abs() <= 1e50) && x.iter().any(|x| x.abs() >= 1e-50))
            {
                faults.add(format!("/up/{shape}"), "must have a length, from 1e-50 to 1e50");
            }
        }
        match self.alignment {
            Alignment::View { weight } if !(0.0..=1e6).contains(&weight) => {
                faults.add("/alignment/weight", format!("must be 0 to 1000000, is {weight:?}"));
            }
            Alignment::View { .. } => {}
            Alignment::None {} => {
                if self.conversion == (Conversion::Alignment {}) {
                    faults.add("/conversion", "needs an alignment of views");
                }
                if self.part == Part::Side {
                    faults.add("/part", "one side can only be told with an alignment of views");
                }
            }
        }
    }

    /// Of functions and a map that are given.
    fn given_faults(&self, faults: &mut Faults) {
        faults.range("/functions", self.functions.len(), 0, MAX_FUNCTIONS);
        for (i, FunctionPair { sketch, mesh }) in self.functions.iter().enumerate() {
            faults.numbers(&format!("/functions/{i}/sketch"), sketch);
            faults.numbers(&format!("/functions/{i}/mesh"), mesh);
        }
        if let Some(GivenMap::C { rows }) = &self.given_map {
            let Basis { k, k_mesh, .. } = self.basis;
            if rows.len() != k_mesh || rows.iter().any(|row| row.len() != k) {
                let detail = format!("must have {k_mesh} rows of {k} numbers, as the bases have eigenfunctions");
                faults.add("/given_map/rows", detail);
            }
            rows.iter().enumerate().for_each(|(i, row)| faults.numbers(&format!("/given_map/rows/{i}"), row));
        }
    }

    /// Of the terms of the energy and what they weigh.
    fn energy_faults(&self, faults: &mut Faults) {
        for (field, detail) in weights::faults(&self.weights) {
            faults.add(format!("/weights/{field}"), detail);
        }
        for (field, detail) in self.regulariser.faults() {
            faults.add(format!("/regulariser/{field}"), detail);
        }
        faults.range("/terms", self.terms.len(), 0, MAX_TERMS);
        for (i, term) in self.terms.iter().enumerate() {
            for (field, detail) in term.faults() {
                faults.add(format!("/terms/{i}/{field}"), detail);
            }
        }
    }

    fn refinement_faults(&self, faults: &mut Faults) {
        match self.refinement {
            Refinement::None {} => {}
            Refinement::Icp { iterations } => {
                faults.range("/refinement/iterations", iterations, 1, MAX_ICP);
                if self.basis.k != self.basis.k_mesh {
                    faults.add("/refinement", "icp needs a square C: basis.k and basis.k_mesh must be equal");
                }
            }
            Refinement::Zoomout { k, .. } => {
                faults.range("/refinement/k", k, self.basis.k.min(MAX_BASIS), MAX_BASIS);
                let (_, l) = upsampled(self);
                if l > MAX_BASIS {
                    let detail = format!("asks for {l} eigenfunctions of the mesh, the most are {MAX_BASIS}");
                    faults.add("/refinement/k", detail);
                }
            }
        }
    }
}

/// The coordinates of a direction, where there is one.
fn coordinates<const N: usize>(direction: &Direction<N>) -> Option<&[f64]>
where
    [f64; N]: Serialize + DeserializeOwned,
{
    match direction {
        Direction::Along(coordinates) => Some(coordinates),
        Direction::Unknown(_) => None,
    }
}

/// What the shapes themselves rule out: every fault of settings for a sketch and a mesh of these many vertices.
pub fn check(settings: &Settings, sketch_vertices: usize, mesh_vertices: usize) -> Vec<Fault> {
    let mut faults = Faults::default();
    let Basis { k, k_mesh, .. } = settings.basis;
    let (most_k, most_l) = upsampled(settings);
    let mut fits = |pointer: &str, k: usize, vertices: usize, shape: &str| {
        if k > vertices {
            faults.add(pointer, format!("{k} eigenfunctions need as many vertices, the {shape} has {vertices}"));
        }
    };
    fits("/basis/k", k, sketch_vertices, "sketch");
    fits("/basis/k_mesh", k_mesh, mesh_vertices, "mesh");
    if (most_k, most_l) != (k, k_mesh) {
        fits("/refinement/k", most_k, sketch_vertices, "sketch");
        fits("/refinement/k", most_l, mesh_vertices, "mesh");
    }
    if let Regions::Given { sketch, mesh } = &settings.regions {
        for (name, labels, vertices) in [("sketch", sketch, sketch_vertices), ("mesh", mesh, mesh_vertices)] {
            faults.counted(format!("/regions/{name}"), "a label", labels.len(), vertices, "vertices");
        }
    }
    for (i, pair) in settings.functions.iter().enumerate() {
        for (name, values, vertices) in [("sketch", &pair.sketch, sketch_vertices), ("mesh", &pair.mesh, mesh_vertices)]
        {
            faults.counted(format!("/functions/{i}/{name}"), "a number", values.len(), vertices, "vertices");
        }
    }
    let missing = |vertex: u32| format!("there is no vertex {vertex}, the mesh has {mesh_vertices}");
    if let Some(GivenMap::Points { mesh_vertices: vertices }) = &settings.given_map {
        let pointer = "/given_map/mesh_vertices";
        faults.counted(pointer, "one", vertices.len(), sketch_vertices, "vertices of the sketch");
        if let Some(i) = vertices.iter().position(|&vertex| vertex as usize >= mesh_vertices) {
            faults.add(format!("{pointer}/{i}"), missing(vertices[i]));
        }
    }
    for (i, landmark) in settings.landmarks.iter().enumerate() {
        if landmark.mesh as usize >= mesh_vertices {
            faults.add(format!("/landmarks/{i}/mesh"), missing(landmark.mesh));
        }
    }
    faults.0
}

/// The labels that occur, label i as bit i.
fn labels_occurring(labels: &[i32]) -> Result<u64, LabelOutOfRange> {
    const NO_REGION: i32 = crate::regions::Regions::NONE;
    const { assert!(MAX_REGIONS == u64::BITS as usize) };
    labels.iter().enumerate().try_fold(0, |occurring, (vertex, &label)| match label {
        NO_REGION => Ok(occurring),
        0..=63 => Ok(occurring | 1 << label),
        _ => Err(LabelOutOfRange { vertex, label }),
    })
}

/// The first number that is too large to reckon with, and why.
pub fn too_large(numbers: &[f64]) -> Option<(usize, String)> {
    let found = numbers.iter().position(|x| x.is_nan() || x.abs() > LARGEST_NUMBER)?;
    Some((found, format!("must be at most {LARGEST_NUMBER:e}, is {:?}", numbers[found])))
}

#[cfg(test)]
mod tests {
    use serde_json::{Value, json};

    use super::*;

    #[test]
    fn numbers_that_are_given_are_not_too_large_to_reckon_with() {
        let faults = |request: Value| Settings::resolve(&serde_json::from_value(request).unwrap()).err();
        let map = |x: f64| json!({"mesh": "m", "sketch": "s", "given_map": {"type": "c", "rows": [[0, 0], [0, x]]}});
        let of_functions = |x: f64| {
            let functions = json!([{"sketch": [0], "mesh": [0]}, {"sketch": [0, 0, x], "mesh": [1, x, x]}]);
            json!({"mesh": "m", "sketch": "s", "functions": functions})
        };
        for x in [LARGEST_NUMBER, -LARGEST_NUMBER] {
            assert_eq!((faults(map(x)), faults(of_functions(x))), (None, None));
            let pointers = |request: Value| -> Vec<String> {
                faults(request).unwrap_or_default().into_iter().map(|fault| fault.pointer).collect()
            };
            assert_eq!(pointers(map(1.1 * x)), ["/given_map/rows/1/1"]);
            assert_eq!(pointers(of_functions(1.1 * x)), ["/functions/1/sketch/2", "/functions/1/mesh/1"]);
        }
    }
}
