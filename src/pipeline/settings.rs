//! What a match is asked to do with every value filled in, and whether it can be done.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::Fault;
use super::request::{
    Alignment, Columns, Conversion, Coupling, Direction, FunctionPair, GivenMap, Landmark, MatchRequest, Part, Preset,
    Refinement, Regions, SpectralScale, Ups,
};
use crate::alignment::prepared::standing::Up;
use crate::functional_map::regulariser::{L1, Regulariser};
use crate::functional_map::term::Term;
use crate::functional_map::weights::{self, Weights};
use crate::regions::{LabelOutOfRange, MAX_REGIONS};
use crate::spectral::Boundary;

/// The most eigenfunctions of a basis.
pub const MAX_BASIS: usize = 500;
const MAX_COMPONENTS: usize = 1000;
const MAX_LANDMARKS: usize = 1000;
/// Widths of a band of energy in spacings of the energies; in a narrower one there is no room for rounding.
const VARIANCES: std::ops::RangeInclusive<f64> = 1e-6..=1e6;
/// The most components of a mesh that a request names.
const MAX_COMPONENTS_NAMED: usize = 10_000;
const MAX_ICP: usize = 200;
const MAX_TERMS: usize = 8;
const MAX_FUNCTIONS: usize = 1000;
/// The largest magnitude of a number in a map or a function that is given. Energies are squares of a map times a function: times
/// all weights and counts there are they stay far from overflow, which JSON has no number for.
const LARGEST_NUMBER: f64 = 1e50;

/// A match request with every value filled in. Its JSON is a match request again, and asks for the same.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Settings {
    pub mesh: String,
    pub sketch: String,
    pub preset: Preset,
    /// The components that are matched as one figure, ascending; nothing where there is nothing to choose.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(min_items = 1, max_items = 10_000)]
    pub components: Option<Vec<usize>>,
    pub part: Part,
    pub alignment: Alignment,
    #[serde(default)]
    pub up: Ups,
    pub basis: Basis,
    pub descriptors: Descriptors,
    pub regions: Regions,
    pub landmarks: Vec<Landmark>,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub functions: Vec<FunctionPair>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub given_map: Option<GivenMap>,
    pub weights: Weights,
    pub regulariser: Regulariser,
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub terms: Vec<Term>,
    pub conversion: Conversion,
    pub refinement: Refinement,
}

/// The bases: C is `k_mesh` × `k`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Basis {
    pub k: usize,
    pub k_mesh: usize,
    pub boundary: Boundary,
    #[serde(default, skip_serializing_if = "Coupling::is_none")]
    pub coupling: Coupling,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Descriptors {
    pub hks: Heat,
    pub wks: Wave,
    pub spectral_scale: SpectralScale,
    pub columns: Columns,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Heat {
    pub count: usize,
    /// In units of 1/λ at unit area; from the spectrum where there is none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<Vec<f64>>, min_items = 2, max_items = 2)]
    pub times: Option<[f64; 2]>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Wave {
    pub count: usize,
    pub variance: f64,
}

impl Settings {
    /// The settings with what was found to be up on the mesh, where that is sure and they say nothing of it.
    pub fn standing(mut self, up: Option<Up>) -> Settings {
        if let (Alignment::View { .. }, Some(up)) = (&self.alignment, up.filter(Up::is_sure)) {
            self.up.mesh.get_or_insert(Direction::Along(up.direction));
        }
        self
    }

    /// The settings of the thesis, §4.1, or those that measured best without a hand, for the given shapes.
    fn preset(preset: Preset, mesh: String, sketch: String) -> Settings {
        let thesis = Settings {
            mesh,
            sketch,
            preset,
            components: None,
            part: Part::Whole,
            alignment: Alignment::None {},
            up: Ups::default(),
            basis: Basis { k: 20, k_mesh: 20, boundary: Boundary::Neumann, coupling: Coupling::None {} },
            descriptors: Descriptors {
                hks: Heat { count: 100, times: None },
                wks: Wave { count: 100, variance: 6.0 },
                spectral_scale: SpectralScale::Fitted,
                columns: Columns::Unit,
            },
            regions: Regions::Auto { count: 7 },
            landmarks: Vec::new(),
            functions: Vec::new(),
            given_map: None,
            weights: Weights::Cosamp { sparsity: 0.8, power: 1.2 },
            regulariser: Regulariser::L1(L1::default()),
            terms: Vec::new(),
            conversion: Conversion::Indicator {},
            refinement: Refinement::None {},
        };
        match preset {
            Preset::Thesis => thesis,
            Preset::Automatic => Settings {
                part: Part::Auto,
                alignment: Alignment::View { weight: Alignment::weight() },
                weights: Weights::Slant {},
                conversion: Conversion::Alignment {},
                ..thesis
            },
        }
    }

    /// The request on top of its preset.
    ///
    /// # Errors
    /// Every value out of its range, with its place. What depends on the shapes is left to [`check`].
    pub fn resolve(request: &MatchRequest) -> Result<Settings, Vec<Fault>> {
        let preset = request.preset.unwrap_or_default();
        let mut settings = Settings::preset(preset, request.mesh.clone(), request.sketch.clone());
        if let Some(given) = &request.given_map {
            settings.alignment = Alignment::None {};
            if let GivenMap::C { rows } = given {
                settings.basis.k_mesh = rows.len();
                settings.basis.k = rows.first().map_or(0, Vec::len);
            }
        }
        if let Some(basis) = &request.basis {
            settings.basis.k = basis.k.unwrap_or(settings.basis.k);
            settings.basis.k_mesh = basis.k_mesh.or(basis.k).unwrap_or(settings.basis.k_mesh);
            settings.basis.boundary = basis.boundary.unwrap_or(settings.basis.boundary);
            settings.basis.coupling = basis.coupling.unwrap_or(settings.basis.coupling);
        }
        if let Some(descriptors) = request.descriptors.clone() {
            let (hks, wks) = (descriptors.hks.unwrap_or_default(), descriptors.wks.unwrap_or_default());
            let defaults = &mut settings.descriptors;
            defaults.hks = Heat { count: hks.count.unwrap_or(defaults.hks.count), times: hks.times };
            defaults.wks.count = wks.count.unwrap_or(defaults.wks.count);
            defaults.wks.variance = wks.variance.unwrap_or(defaults.wks.variance);
            defaults.spectral_scale = descriptors.spectral_scale.unwrap_or(defaults.spectral_scale);
            defaults.columns = descriptors.columns.unwrap_or(defaults.columns);
        }
        let request = request.clone();
        settings.components = request.components;
        settings.part = request.part.unwrap_or(settings.part);
        settings.alignment = request.alignment.unwrap_or(settings.alignment);
        if settings.alignment == (Alignment::None {}) {
            // What only an alignment can do is not asked for by a preset.
            if settings.conversion == (Conversion::Alignment {}) {
                settings.conversion = Conversion::Nearest {};
            }
            if settings.part == Part::Auto {
                settings.part = Part::Whole;
            }
        }
        settings.up = request.up.unwrap_or_default();
        settings.regions = request.regions.unwrap_or(settings.regions);
        settings.landmarks = request.landmarks.unwrap_or(settings.landmarks);
        settings.functions = request.functions.unwrap_or_default();
        settings.given_map = request.given_map;
        settings.weights = request.weights.unwrap_or(settings.weights);
        settings.regulariser = request.regulariser.unwrap_or(settings.regulariser);
        settings.terms = request.terms.unwrap_or_default();
        settings.conversion = request.conversion.unwrap_or(settings.conversion);
        settings.refinement = request.refinement.unwrap_or(settings.refinement);
        let faults = settings.faults();
        if faults.is_empty() { Ok(settings) } else { Err(faults) }
    }

    /// Every value out of its range.
    fn faults(&self) -> Vec<Fault> {
        let mut faults = Faults::default();
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
        let Descriptors { hks, wks, .. } = &self.descriptors;
        faults.range("/descriptors/hks/count", hks.count, 0, MAX_COMPONENTS);
        if let Some([first, last]) = hks.times
            && !(first >= 1e-12 && first <= last && last <= 1e12)
        {
            faults.add("/descriptors/hks/times", "must be two times in ascending order, from 1e-12 to 1e12");
        }
        faults.range("/descriptors/wks/count", wks.count, 0, MAX_COMPONENTS);
        if !VARIANCES.contains(&wks.variance) {
            let (least, most) = (VARIANCES.start(), VARIANCES.end());
            faults.add("/descriptors/wks/variance", format!("must be {least} to {most}, is {:?}", wks.variance));
        }
        if let Some(components) = &self.components {
            faults.range("/components", components.len(), 1, MAX_COMPONENTS_NAMED);
        }
        self.region_faults(&mut faults);
        self.alignment_faults(&mut faults);
        if self.landmarks.len() > MAX_LANDMARKS {
            faults.add("/landmarks", format!("must be at most {MAX_LANDMARKS}"));
        }
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
        faults.0
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
}

/// The coordinates of a direction, where there is one.
fn coordinates<const N: usize>(direction: &Direction<N>) -> Option<&[f64]>
where
    [f64; N]: Serialize + serde::de::DeserializeOwned,
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
            if labels.len() != vertices {
                let detail = format!("must have a label for each of the {vertices} vertices, has {}", labels.len());
                faults.add(format!("/regions/{name}"), detail);
            }
        }
    }
    for (i, pair) in settings.functions.iter().enumerate() {
        for (name, values, vertices) in [("sketch", &pair.sketch, sketch_vertices), ("mesh", &pair.mesh, mesh_vertices)]
        {
            if values.len() != vertices {
                let detail = format!("must have a number for each of the {vertices} vertices, has {}", values.len());
                faults.add(format!("/functions/{i}/{name}"), detail);
            }
        }
    }
    if let Some(GivenMap::Points { mesh_vertices: vertices }) = &settings.given_map {
        if vertices.len() != sketch_vertices {
            let detail = format!(
                "must have one for each of the {sketch_vertices} vertices of the sketch, has {}",
                vertices.len()
            );
            faults.add("/given_map/mesh_vertices", detail);
        }
        if let Some(i) = vertices.iter().position(|&vertex| vertex as usize >= mesh_vertices) {
            let detail = format!("there is no vertex {}, the mesh has {mesh_vertices}", vertices[i]);
            faults.add(format!("/given_map/mesh_vertices/{i}"), detail);
        }
    }
    for (i, landmark) in settings.landmarks.iter().enumerate() {
        if landmark.mesh as usize >= mesh_vertices {
            let detail = format!("there is no vertex {}, the mesh has {mesh_vertices}", landmark.mesh);
            faults.add(format!("/landmarks/{i}/mesh"), detail);
        }
    }
    faults.0
}

/// The sizes (k, l) of the bases after refinement; ZoomOut keeps their proportion.
pub fn upsampled(settings: &Settings) -> (usize, usize) {
    let Basis { k, k_mesh, .. } = settings.basis;
    match settings.refinement {
        Refinement::Zoomout { k: last, .. } => (last, k_mesh.saturating_mul(last).div_ceil(k.max(1))),
        _ => (k, k_mesh),
    }
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

    /// The first of the numbers that is too large.
    fn numbers(&mut self, pointer: &str, numbers: &[f64]) {
        if let Some((i, detail)) = too_large(numbers) {
            self.add(format!("{pointer}/{i}"), detail);
        }
    }
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
