//! What a match is asked to do, as the user sends it.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use utoipa::openapi::Ref;
use utoipa::openapi::schema::{ArrayBuilder, ObjectBuilder, OneOfBuilder, Type};

use crate::functional_map::{regulariser::Regulariser, term::Term, weights::Weights};
use crate::regions::MAX_REGIONS;
use crate::spectral::Boundary;

/// A match request as the user sends it: only `mesh` and `sketch` are required; what is left out comes from the preset.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct MatchRequest {
    /// Id of an uploaded mesh.
    pub mesh: String,
    /// Id of an uploaded sketch; over HTTP also the drawing itself.
    #[schema(schema_with = sketch_schema)]
    pub sketch: String,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub preset: Option<Preset>,
    /// Numbers of the components that are matched as one figure, as `GET /v1/meshes/{id}/components` lists them; by default
    /// what looks most like the sketch.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(min_items = 1, max_items = 10_000)]
    pub components: Option<Vec<usize>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub part: Option<Part>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub alignment: Option<Alignment>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub up: Option<Ups>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub basis: Option<BasisRequest>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub descriptors: Option<DescriptorsRequest>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub regions: Option<Regions>,
    /// What is known of the correspondence. All are kept exactly; of more than 200 the first 200 move what is around them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(max_items = 1000)]
    pub landmarks: Option<Vec<Landmark>>,
    /// Functions of one's own that correspond, beside those that are made here.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(max_items = 1000)]
    pub functions: Option<Vec<FunctionPair>>,
    /// A map of one's own, which is taken instead of the minimiser and converted and refined as others are; no alignment is
    /// sought unless one is asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub given_map: Option<GivenMap>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub weights: Option<Weights>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub regulariser: Option<Regulariser>,
    /// Quadratic terms beside the data, as `GET /v1/terms` lists them; none where it is not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(max_items = 8)]
    pub terms: Option<Vec<Term>>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub conversion: Option<Conversion>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub refinement: Option<Refinement>,
}

/// A functional map that is known already.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum GivenMap {
    /// C by rows, `k_mesh` × `k`, between the bases at area 1 as spectra have them.
    C {
        #[schema(schema_with = matrix_schema)]
        rows: Vec<Vec<f64>>,
    },
    /// A vertex of the mesh for every vertex of the sketch, of which C is made.
    Points { mesh_vertices: Vec<u32> },
}

/// A function of the sketch and the one of the mesh that it corresponds to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct FunctionPair {
    /// A number for every vertex of the sketch.
    pub sketch: Vec<f64>,
    /// One for every vertex of the user's mesh file.
    pub mesh: Vec<f64>,
}

/// The schema of a matrix by rows.
fn matrix_schema() -> ArrayBuilder {
    let entry = ObjectBuilder::new().schema_type(Type::Number);
    let row = ArrayBuilder::new().items(entry).min_items(Some(1)).max_items(Some(500));
    ArrayBuilder::new().items(row).min_items(Some(1)).max_items(Some(500))
}

/// The schema of an id or a drawing: the service takes the drawing apart before it reads the request.
fn sketch_schema() -> OneOfBuilder {
    let id = ObjectBuilder::new().schema_type(Type::String);
    let description = "Id of an uploaded sketch, or the drawing itself.";
    OneOfBuilder::new().description(Some(description)).item(id).item(Ref::from_schema_name("OutlineRequest"))
}

/// Where the values come from that a request does not name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Preset {
    /// The settings that measured best.
    #[default]
    Automatic,
    /// The settings of the thesis, §4.1.
    Thesis,
}

/// Which part of the mesh the sketch shows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Part {
    /// One side where the alignment sees the body from its side and nothing beyond, such as a far leg; the whole otherwise.
    Auto,
    Whole,
    /// The side towards the camera; needs an alignment.
    Side,
}

/// How the sketch is brought onto the mesh before the functional map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "method", rename_all = "snake_case", deny_unknown_fields)]
pub enum Alignment {
    /// By the view of the mesh that the sketch is drawn from, found without a hand.
    View {
        /// How much the aligned points weigh in the data term beside the regions; 0 leaves them out.
        #[serde(default = "Alignment::weight")]
        #[schema(minimum = 0, maximum = 1_000_000, default = 1000.0)]
        weight: f64,
    },
    /// Not at all: the method is intrinsic.
    None {},
}

impl Alignment {
    /// The weight of the aligned points where the request names none.
    pub fn weight() -> f64 {
        1000.0
    }
}

/// Which way is up on the shapes; used softly, and only where it is known of both.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Ups {
    /// The direction in the coordinates of the upload that is up on what is drawn, or `none`; by default the top of the
    /// drawing.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(schema_with = up_schema::<2>)]
    pub sketch: Option<Direction<2>>,
    /// The direction in the axes of the mesh's file, or `none`; by default that which the mesh's upload was answered with,
    /// where it is surer than even.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(schema_with = up_schema::<3>)]
    pub mesh: Option<Direction<3>>,
}

/// A direction of any positive length, or that there is none.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged, expecting = "must be a list of coordinates, or \"none\"")]
pub enum Direction<const N: usize>
where
    [f64; N]: Serialize + serde::de::DeserializeOwned,
{
    Along([f64; N]),
    Unknown(Unknown),
}

/// That there is no direction.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Unknown {
    None,
}

/// The schema of a direction or `none`.
fn up_schema<const N: usize>() -> OneOfBuilder {
    let coordinate = ObjectBuilder::new().schema_type(Type::Number);
    let along = ArrayBuilder::new().items(coordinate).min_items(Some(N)).max_items(Some(N));
    let none = ObjectBuilder::new().schema_type(Type::String).enum_values(Some(["none"]));
    OneOfBuilder::new().item(along).item(none)
}

/// The Laplace–Beltrami bases.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct BasisRequest {
    /// Eigenfunctions of the sketch: columns of C.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 500)]
    pub k: Option<usize>,
    /// Eigenfunctions of the mesh: rows of C; `k` where it is not given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1, maximum = 500)]
    pub k_mesh: Option<usize>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub boundary: Option<Boundary>,
    /// Whether the bases of both shapes are turned until they go together.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub coupling: Option<Coupling>,
}

/// How the bases of both shapes are made to go together; C is answered between the eigenfunctions all the same.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "method", rename_all = "snake_case", deny_unknown_fields)]
pub enum Coupling {
    /// They are the eigenfunctions.
    None {},
    /// They are turned so that both Laplacians stay nearly diagonal and corresponding functions have nearly equal coefficients;
    /// needs as many eigenfunctions of either shape.
    JointDiagonalisation {
        /// Weight of the functions against the Laplacians.
        #[serde(default = "Coupling::weight")]
        #[schema(exclusive_minimum = 0, maximum = 1_000_000, default = 1.0)]
        weight: f64,
    },
}

impl Default for Coupling {
    fn default() -> Coupling {
        Coupling::None {}
    }
}

impl Coupling {
    fn weight() -> f64 {
        1.0
    }

    /// Whether the bases are the eigenfunctions.
    pub fn is_none(&self) -> bool {
        *self == Coupling::None {}
    }
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct DescriptorsRequest {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hks: Option<HeatRequest>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wks: Option<WaveRequest>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spectral_scale: Option<SpectralScale>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub columns: Option<Columns>,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct HeatRequest {
    /// Number of times; 0 leaves the heat kernel out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(maximum = 1000)]
    pub count: Option<usize>,
    /// First and last time in units of 1/λ of the sketch's spectrum; by default 4 ln 10 / λ_max to 4 ln 10 / λ_2.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<Vec<f64>>, min_items = 2, max_items = 2)]
    pub times: Option<[f64; 2]>,
}

#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct WaveRequest {
    /// Number of energies; 0 leaves the wave kernel out.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(maximum = 1000)]
    pub count: Option<usize>,
    /// Width of an energy's band in spacings of the energies.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(minimum = 1e-6, maximum = 1_000_000)]
    pub variance: Option<f64>,
}

/// The factor on the mesh's eigenvalues before descriptors are made of them.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum SpectralScale {
    /// exp(mean of log λ_sketch − log λ_mesh) over the common eigenvalues without the first.
    Fitted,
    /// area(mesh) / area(sketch): both shapes scaled to one area.
    Area,
    /// The square of it, as the thesis prints.
    AreaSquared,
    None,
}

/// How the columns of the constraint matrices A and B are scaled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Columns {
    /// Every column of A and of B to Euclidean norm 1.
    Unit,
    /// As they come, both shapes scaled to area 1.
    Raw,
}

/// The regions whose correspondence is given or found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "method", rename_all = "snake_case", deny_unknown_fields)]
pub enum Regions {
    /// With an alignment the sketch segmented into `count` regions, carried to the mesh by it; without, both shapes
    /// segmented and the regions paired by assignment on their signatures.
    Auto {
        #[serde(default = "seven")]
        #[schema(minimum = 1, maximum = 64, default = 7)]
        count: usize,
    },
    /// Labels per vertex, equal labels corresponding; −1 is in no region.
    Given { sketch: Vec<i32>, mesh: Vec<i32> },
    /// Both shapes segmented, the pairs (sketch region, mesh region) by the user.
    Segmented {
        #[schema(minimum = 1, maximum = 64)]
        sketch_regions: usize,
        #[schema(minimum = 1, maximum = 64)]
        mesh_regions: usize,
        #[schema(schema_with = pairs_schema)]
        pairs: Vec<[usize; 2]>,
    },
}

fn seven() -> usize {
    7
}

/// The schema of pairs of regions: one derived from `[usize; 2]` says nothing of the length.
fn pairs_schema() -> ArrayBuilder {
    let region = ObjectBuilder::new().schema_type(Type::Integer).minimum(Some(0)).maximum(Some(MAX_REGIONS - 1));
    let pair = ArrayBuilder::new().items(region).min_items(Some(2)).max_items(Some(2));
    ArrayBuilder::new().items(pair).min_items(Some(1)).max_items(Some(MAX_REGIONS))
}

/// A point of the sketch, in the coordinates it was uploaded in, and the mesh vertex it is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Landmark {
    #[schema(value_type = Vec<f64>, min_items = 2, max_items = 2)]
    pub sketch: [f64; 2],
    pub mesh: u32,
}

/// How points are read from C.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "method", rename_all = "snake_case", deny_unknown_fields)]
pub enum Conversion {
    /// The vertex where the image of the point's indicator is largest.
    Indicator {},
    /// The vertex whose row of Ψ is nearest to the point's column of C Φᵀ.
    Nearest {},
    /// The points of the alignment itself, whatever C is.
    Alignment {},
}

/// How C and the points are improved afterwards.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "method", rename_all = "snake_case", deny_unknown_fields)]
pub enum Refinement {
    None {},
    /// Alternating nearest points and orthonormal C; needs a square C.
    Icp {
        #[serde(default = "ten")]
        #[schema(minimum = 1, maximum = 200, default = 10)]
        iterations: usize,
    },
    /// Spectral upsampling to `k` eigenfunctions of the sketch.
    Zoomout {
        #[schema(minimum = 1, maximum = 500)]
        k: usize,
        #[serde(default, skip_serializing_if = "Within::is_mesh")]
        within: Within,
    },
}

/// Where points are looked for while a map is refined.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Within {
    /// On all of the mesh.
    #[default]
    Mesh,
    /// On the part that the sketch shows: the side that is seen where an alignment says so, else what is in a region.
    Part,
}

impl Within {
    fn is_mesh(&self) -> bool {
        *self == Within::Mesh
    }
}

fn ten() -> usize {
    10
}
