//! What a match was computed from, made again out of its result: the constraints A and B.

use faer::{Mat, MatRef};

use super::bases::{ASKED_BY, at_unit_area, both};
use super::constraints::{Constraints, Points, count, each, given, partial};
use super::outcome::MatchResult;
use super::regions::Correspondence;
use super::run::weight;
use super::{MatchError, Spectra, figure, landmarks};
use crate::functional_map::regulariser::Regulariser;
use crate::mesh::file_mesh::FileMesh;
use crate::numerics::Watch;
use crate::regions::Regions;
use crate::sketch::Sketch;

/// The corresponding functions of a match.
pub struct Inside {
    /// k × q.
    pub a: Mat<f64>,
    /// l × q.
    pub b: Mat<f64>,
}

/// How many corresponding functions, q, the data term of a match had.
pub fn functions(result: &MatchResult) -> usize {
    let points = if weight(&result.request.alignment).is_some() { result.correspondences.len() } else { 0 };
    count(&result.request, result.intermediate.regions.pairs.len(), points)
}

impl Inside {
    /// That of a match of these two shapes: what the solvers saw, column for column.
    ///
    /// # Errors
    /// [`MatchError`]: what kept the match itself from being carried out would keep it again.
    pub fn of(
        sketch: &Sketch,
        mesh: &FileMesh,
        result: &MatchResult,
        spectra: &dyn Spectra,
        watch: &dyn Watch,
    ) -> Result<Inside, MatchError> {
        let settings = &result.request;
        let figure = figure::matched(mesh, settings)?;
        let (k, l, boundary) = (settings.basis.k, settings.basis.k_mesh, settings.basis.boundary);
        let both = both(spectra, (sketch, &figure), [k, l], boundary, ASKED_BY, watch)?;
        let [phi, psi] = at_unit_area(&both, [k, l]);
        let scaled: Vec<f64> = psi.eigenvalues.iter().map(|l| result.intermediate.spectral_scale * l).collect();
        let landmarks = landmarks::vertices(&settings.landmarks, sketch, &figure).map_err(MatchError::Faults)?;

        let known = &result.intermediate.regions;
        let regions = |labels: Vec<i32>| Regions::new(labels).map_err(|_| MatchError::Faults(Vec::new()));
        let on_figure = figure.vertices.iter().map(|&v| known.mesh.get(v as usize).copied().unwrap_or(Regions::NONE));
        let regions = Correspondence {
            sketch: regions(known.sketch.clone())?,
            mesh: regions(on_figure.collect())?,
            pairs: known.pairs.clone(),
            cost: known.cost,
        };
        let aligned = result.alignment.iter().flat_map(|alignment| &alignment.mesh_vertices);
        let map: Vec<u32> = aligned.map(|&v| figure.at(v).map_or(0, |own| own as u32)).collect();
        let points = weight(&settings.alignment).filter(|_| !map.is_empty()).map(|weight| Points { map: &map, weight });

        let functions = given(&settings.functions, &figure);
        let (mut on_sketch, mut on_mesh) = (Vec::new(), Vec::new());
        let mut constraints = Constraints {
            descriptors: &settings.descriptors,
            spectra: [&phi, &psi],
            scaled: &scaled,
            regions: &regions,
            landmarks: &landmarks,
            functions: functions.as_ref(),
            points,
        };
        // Functions of regions count as far as the part that was found does; the others come after them.
        let unpaired = regions.unpaired();
        if let (Some(part), Regulariser::PartIndicator(term)) = (&result.intermediate.part, &settings.regulariser) {
            let part: Vec<f64> =
                figure.vertices.iter().map(|&v| part.get(v as usize).copied().unwrap_or(0.0)).collect();
            let of_regions = partial(&constraints, &figure.mesh, term.area, watch)?.functions(&part, watch)?;
            for [a, b] in of_regions {
                on_sketch.push(a);
                on_mesh.push(b);
            }
            constraints.regions = &unpaired;
        }
        let mut collect = |a: Mat<f64>, b: Mat<f64>| {
            on_sketch.push(a);
            on_mesh.push(b);
            Ok(())
        };
        each(&constraints, &mut collect, watch)?;
        Ok(Inside { a: beside(k, &on_sketch), b: beside(l, &on_mesh) })
    }
}

/// Blocks of so many rows beside each other.
fn beside(rows: usize, blocks: &[Mat<f64>]) -> Mat<f64> {
    let columns: Vec<(MatRef<'_, f64>, usize)> =
        blocks.iter().flat_map(|block| (0..block.ncols()).map(move |j| (block.as_ref(), j))).collect();
    Mat::from_fn(rows, columns.len(), |i, j| columns[j].0[(i, columns[j].1)])
}
