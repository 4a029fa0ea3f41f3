//! What a match is asked to do with every value filled in, and whether it can be done.

mod faults;

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
use crate::functional_map::weights::Weights;
use crate::spectral::Boundary;
pub use faults::{MAX_SIGNATURE, check, too_large};

/// Components of the heat and of the wave kernel signature where a request names no number, §4.1.
pub const SIGNATURE: usize = 100;
/// The width of a band of energy where a request names none, in spacings of the energies, §4.1.
pub const VARIANCE: f64 = 6.0;
/// Regions of a shape where a request names no number, §4.1.
pub const REGIONS: usize = 7;

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
                hks: Heat { count: SIGNATURE, times: None },
                wks: Wave { count: SIGNATURE, variance: VARIANCE },
                spectral_scale: SpectralScale::Fitted,
                columns: Columns::Unit,
            },
            regions: Regions::Auto { count: REGIONS },
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
}

/// The sizes (k, l) of the bases after refinement; ZoomOut keeps their proportion.
pub fn upsampled(settings: &Settings) -> (usize, usize) {
    let Basis { k, k_mesh, .. } = settings.basis;
    match settings.refinement {
        Refinement::Zoomout { k: last, .. } => (last, k_mesh.saturating_mul(last).div_ceil(k.max(1))),
        _ => (k, k_mesh),
    }
}
