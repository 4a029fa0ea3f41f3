//! The regions of both shapes and their pairs, by the method the request names.

use super::aligned::Aligned;
use super::outcome::PairedRegions;
use super::request::Regions as Method;
use super::{Fault, MatchError, Settings};
use crate::correspondence::inverse;
use crate::descriptors::{global_point_signature, heat_kernel, projection, wave_kernel};
use crate::mesh::TriangleMesh;
use crate::mesh::figure::Figure;
use crate::mesh::file_mesh::FileMesh;
use crate::numerics::{Cancelled, Watch};
use crate::regions::graph::RegionGraph;
use crate::regions::pairing::{RegionPair, pair};
use crate::regions::{Regions, consensus};
use crate::spectral::Spectrum;

/// Dimensions of the global point signature that shapes are segmented in: the lowest tell limbs, the higher only
/// bumps.
const SIGNATURE: usize = 7;
/// Heat and wave components that regions are compared by.
const COMPONENTS: usize = 8;
/// Bands of the wave components, in spacings: few components, so narrow ones.
const VARIANCE: f64 = 1.5;

/// Segmentations of both shapes, the mesh's over the vertices of its figure, and their pairs.
#[derive(Clone)]
pub(super) struct Correspondence {
    pub sketch: Regions,
    pub mesh: Regions,
    pub pairs: Vec<RegionPair>,
    pub cost: f64,
}

/// A shape as regions are found on it: its mesh and its spectrum at area 1.
#[derive(Clone, Copy)]
pub(super) struct Shape<'a> {
    pub mesh: &'a TriangleMesh,
    pub spectrum: &'a Spectrum,
}

impl Correspondence {
    /// The corresponding regions of a sketch and of the figure of a mesh.
    pub fn find(
        settings: &Settings,
        sketch: Shape<'_>,
        mesh: Shape<'_>,
        (file, figure): (&FileMesh, &Figure),
        aligned: Option<&Aligned>,
        scaled: &[f64],
        watch: &dyn Watch,
    ) -> Result<Correspondence, MatchError> {
        match &settings.regions {
            Method::Given { sketch, mesh } => given(sketch, mesh, file, figure),
            Method::Segmented { sketch_regions, mesh_regions, pairs } => {
                let sketch = segmentation(sketch, *sketch_regions, watch)?;
                let mesh = segmentation(mesh, *mesh_regions, watch)?;
                let pairs = chosen(pairs, &sketch, &mesh)?;
                Ok(Correspondence { sketch, mesh, pairs, cost: 0.0 })
            }
            Method::Auto { count } if let Some(aligned) = aligned => {
                let sketch = segmentation(sketch, *count, watch)?;
                let mesh = carried(&sketch, mesh.mesh, aligned, watch)?;
                let pairs = (0..sketch.count().min(mesh.count())).map(|r| RegionPair { sketch: r, mesh: r, cost: 0.0 });
                Ok(Correspondence { pairs: pairs.collect(), sketch, mesh, cost: 0.0 })
            }
            Method::Auto { count } => {
                let sketch_regions = segmentation(sketch, *count, watch)?;
                let mesh_regions = segmentation(mesh, *count, watch)?;
                let sketch_eigenvalues = &sketch.spectrum.eigenvalues;
                let pairing = pair(
                    &graph(sketch, &sketch_regions, sketch_eigenvalues, sketch_eigenvalues),
                    &graph(mesh, &mesh_regions, scaled, sketch_eigenvalues),
                );
                Ok(Correspondence {
                    sketch: sketch_regions,
                    mesh: mesh_regions,
                    pairs: pairing.pairs,
                    cost: pairing.cost,
                })
            }
        }
    }

    /// The same without pairs.
    pub fn unpaired(&self) -> Correspondence {
        Correspondence { pairs: Vec::new(), ..self.clone() }
    }

    /// What the result says of them: the mesh's labels for the vertices of the user's file.
    pub fn reported(&self, figure: &Figure) -> PairedRegions {
        let label = |vertex: Option<usize>| vertex.map_or(Regions::NONE, |vertex| self.mesh.labels()[vertex]);
        let mesh = figure.of_file().map(label).collect();
        PairedRegions { sketch: self.sketch.labels().to_vec(), mesh, pairs: self.pairs.clone(), cost: self.cost }
    }
}

/// The regions of the sketch on the mesh: every vertex in the region of the aligned point nearest to it along the surface,
/// in none where there is none within reach.
fn carried(sketch: &Regions, mesh: &TriangleMesh, aligned: &Aligned, watch: &dyn Watch) -> Result<Regions, MatchError> {
    watch.proceed(0.0)?;
    let cells = inverse::of_points(mesh, &aligned.alignment.map, watch)?;
    let label = |cell: Option<usize>| cell.map_or(Regions::NONE, |x| sketch.labels()[x]);
    let labels = cells.into_iter().map(label).collect();
    Ok(Regions::new(labels).expect("the labels are those of the sketch's regions"))
}

fn segmentation(shape: Shape<'_>, count: usize, watch: &dyn Watch) -> Result<Regions, MatchError> {
    Ok(segmented(shape.spectrum, count, watch)?)
}

/// At most `count` regions of a shape of this spectrum at area 1, as a match finds them.
///
/// # Errors
/// [`Cancelled`] by the watcher.
pub fn segmented(spectrum: &Spectrum, count: usize, watch: &dyn Watch) -> Result<Regions, Cancelled> {
    let signature = global_point_signature::signature(spectrum, SIGNATURE);
    consensus::segment(signature.as_ref(), &spectrum.mass, count, watch)
}

/// The labels of the request, those of the mesh brought to its figure; equal labels correspond.
fn given(sketch: &[i32], mesh: &[i32], file: &FileMesh, figure: &Figure) -> Result<Correspondence, MatchError> {
    let labels = labels_of_vertices(mesh, file).map_err(MatchError::Faults)?;
    let mesh = figure.vertices.iter().map(|&v| labels[v as usize]).collect();
    let labelled = |pointer: &str, labels: Vec<i32>| {
        Regions::new(labels).map_err(|error| MatchError::Faults(vec![Fault::new(pointer, error.to_string())]))
    };
    let (sketch, mesh) = (labelled("/regions/sketch", sketch.to_vec())?, labelled("/regions/mesh", mesh)?);
    let occurs = |regions: &Regions, label: usize| regions.labels().contains(&(label as i32));
    let pairs: Vec<RegionPair> = (0..sketch.count().min(mesh.count()))
        .filter(|&label| occurs(&sketch, label) && occurs(&mesh, label))
        .map(|label| RegionPair { sketch: label, mesh: label, cost: 0.0 })
        .collect();
    if pairs.is_empty() {
        let detail = "no label occurs both on the sketch and on the part of the mesh that is matched";
        return Err(MatchError::Faults(vec![Fault::new("/regions", detail)]));
    }
    Ok(Correspondence { sketch, mesh, pairs, cost: 0.0 })
}

/// Per vertex of the file its label, that of the lowest vertex being the one of all that are one with it; those in no region
/// have no say. Where the surface was made coarser the label of a vertex that is left is its own, since borders of regions
/// run between those that left to it.
///
/// # Errors
/// Every vertex that has another label than one before it that is one with it.
pub(super) fn labels_of_vertices(labels: &[i32], file: &FileMesh) -> Result<Vec<i32>, Vec<Fault>> {
    let mut of_lowest = labels.to_vec();
    if file.is_decimated() {
        return Ok(of_lowest);
    }
    let mut faults = Vec::new();
    for (v, (&label, &lowest)) in labels.iter().zip(file.merged()).enumerate() {
        let known = &mut of_lowest[lowest as usize];
        if label == Regions::NONE || *known == label {
            continue;
        }
        if *known == Regions::NONE {
            *known = label;
        } else {
            let detail = format!(
                "vertex {v} has label {label}, vertex {lowest} has label {known}: along a seam they are one vertex"
            );
            faults.push(Fault::new(format!("/regions/mesh/{v}"), detail));
        }
    }
    if faults.is_empty() { Ok(of_lowest) } else { Err(faults) }
}

/// The pairs of the request, which may name regions that the segmentation did not find.
fn chosen(pairs: &[[usize; 2]], sketch: &Regions, mesh: &Regions) -> Result<Vec<RegionPair>, MatchError> {
    let mut faults = Vec::new();
    for (i, pair) in pairs.iter().enumerate() {
        for (side, (regions, shape)) in [(sketch, "sketch"), (mesh, "mesh")].into_iter().enumerate() {
            if pair[side] >= regions.count() {
                let detail = format!("the {shape} has only {} regions", regions.count());
                faults.push(Fault::new(format!("/regions/pairs/{i}/{side}"), detail));
            }
        }
    }
    if !faults.is_empty() {
        return Err(MatchError::Faults(faults));
    }
    Ok(pairs.iter().map(|&[sketch, mesh]| RegionPair { sketch, mesh, cost: 0.0 }).collect())
}

/// The regions with their mean heat and wave signatures, made with `eigenvalues` at the times and energies of the
/// `common` spectrum.
fn graph(shape: Shape<'_>, regions: &Regions, eigenvalues: &[f64], common: &[f64]) -> RegionGraph {
    let heat = heat_kernel::filters(eigenvalues, &heat_kernel::times(common, COMPONENTS));
    let wave = wave_kernel::filters(eigenvalues, &wave_kernel::energies(common, COMPONENTS, VARIANCE));
    let filters = faer::Mat::from_fn(eigenvalues.len(), heat.ncols() + wave.ncols(), |i, j| {
        if j < heat.ncols() { heat[(i, j)] } else { wave[(i, j - heat.ncols())] }
    });
    let descriptors = projection::at_points(shape.spectrum, filters.as_ref());
    RegionGraph::of(regions, &shape.spectrum.mass, descriptors.as_ref(), shape.mesh.triangles())
}
