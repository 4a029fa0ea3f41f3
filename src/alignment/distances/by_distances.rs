//! The point map from a few sure points and geodesic distances alone: where no view explains the sketch.

use super::distortion::SCALES;
use crate::alignment::prepared::sampled_distances::Place;
use crate::alignment::prepared::{FlatShape, PreparedMesh};
use crate::alignment::scene::landmarks::Pair;
use crate::mesh::farthest_points::FarthestPoints;
use crate::numerics::{Cancelled, Watch, median};

/// Sure points of the outline, and the fewest there must be.
const ANCHORS: usize = 30;
const FEWEST: usize = 15;
/// The cost of the warp below which a vertex of the outline is sure.
const SURE: f64 = 0.15;
/// An anchor whose median distortion is above the larger of this and `OUTLYING` times the median is dropped.
const BENT: f64 = 0.12;
const OUTLYING: f64 = 2.5;

/// A vertex of the sketch, its vertex of the mesh and its distances within the sketch.
struct Anchor {
    sketch: u32,
    mesh: u32,
    near: Vec<f64>,
}

impl Anchor {
    /// # Errors
    /// [`Cancelled`] by the watcher.
    fn of(shape: &FlatShape, Pair { sketch, mesh }: Pair, watch: &dyn Watch) -> Result<Anchor, Cancelled> {
        Ok(Anchor { sketch, mesh, near: shape.distances_from(sketch, watch)? })
    }
}

/// The map T (m vertices of the mesh) that keeps every point's geodesic distances to the sure ones best, near ones
/// above all; nothing where too few points are sure. Sure are those of the outline's vertices, of which `costs` tells,
/// whose answers in `map` agree with each other.
///
/// # Errors
/// [`Cancelled`] by the watcher.
pub fn mapped(
    shape: &FlatShape,
    mesh: &PreparedMesh,
    map: &[u32],
    costs: &[f64],
    watch: &dyn Watch,
) -> Result<Option<Vec<u32>>, Cancelled> {
    let spread = spread(shape, map, costs, watch)?;
    if spread.len() < FEWEST {
        return Ok(None);
    }
    let scale = scale(mesh, &spread);
    let bends: Vec<f64> = spread.iter().map(|anchor| bend(mesh, scale, anchor, &spread)).collect();
    let most = BENT.max(OUTLYING * median(bends.clone()));
    let kept = spread.into_iter().zip(bends).filter(|&(_, bend)| bend < most);
    let anchors: Vec<Anchor> = kept.map(|(anchor, _)| anchor).collect();

    answered(mesh, map.len(), &anchors, scale, watch).map(Some)
}

/// For each of so many vertices of the sketch the vertex of the mesh that keeps its distances to the anchors best, near ones
/// above all, `scale` being a length of the mesh by that of the sketch.
fn answered(
    mesh: &PreparedMesh,
    count: usize,
    anchors: &[Anchor],
    scale: f64,
    watch: &dyn Watch,
) -> Result<Vec<u32>, Cancelled> {
    let vertices = mesh.positions.len() as u32;
    let places: Vec<Place> = anchors.iter().map(|anchor| mesh.distances.at(anchor.mesh)).collect();
    let mut fields = vec![Vec::with_capacity(vertices as usize); anchors.len()];
    for v in 0..vertices {
        watch.proceed(0.0)?;
        let place = mesh.distances.at(v);
        fields.iter_mut().zip(&places).for_each(|(field, anchor)| field.push(anchor.to(&place) as f32));
    }
    let answer = |x: usize| {
        watch.proceed(x as f64 / count as f64)?;
        let wanted: Vec<f64> = anchors.iter().map(|anchor| scale * anchor.near[x]).collect();
        let weights: Vec<f64> = wanted.iter().map(|d| (d + 0.05).powf(-1.5)).collect();
        Ok(nearest(&fields, &wanted, &weights))
    };
    (0..count).map(answer).collect()
}

/// The vertex of the mesh whose distances are nearest to the wanted ones in the weighted squares; of equals, the first.
pub fn nearest<F: AsRef<[f32]>>(fields: &[F], wanted: &[f64], weights: &[f64]) -> u32 {
    let mut costs = vec![0.0f32; fields.first().map_or(0, |field| field.as_ref().len())];
    for ((field, &wanted), &weight) in fields.iter().zip(wanted).zip(weights) {
        let (wanted, weight) = (wanted as f32, weight as f32);
        costs.iter_mut().zip(field.as_ref()).for_each(|(cost, d)| *cost += weight * (d - wanted) * (d - wanted));
    }
    (0..costs.len()).fold(0, |best, v| if costs[v] < costs[best] { v } else { best }) as u32
}

/// Sure vertices of the outline, far from each other.
fn spread(shape: &FlatShape, map: &[u32], costs: &[f64], watch: &dyn Watch) -> Result<Vec<Anchor>, Cancelled> {
    let sure: Vec<u32> = shape.outline.iter().zip(costs).filter(|&(_, &cost)| cost < SURE).map(|(&v, _)| v).collect();
    let mut points = FarthestPoints::new(map.len());
    let mut anchors = Vec::new();
    while anchors.len() < ANCHORS.min(sure.len()) {
        let Some(next) = points.farthest(sure.iter().copied()) else { break };
        let anchor = Anchor::of(shape, Pair { sketch: next, mesh: map[next as usize] }, watch)?;
        points.choose(&anchor.near);
        anchors.push(anchor);
    }
    Ok(anchors)
}

/// The median of a length on the mesh by that on the sketch.
fn scale(mesh: &PreparedMesh, anchors: &[Anchor]) -> f64 {
    let pairs = anchors.iter().enumerate().flat_map(|(i, a)| anchors[..i].iter().map(move |b| (a, b)));
    let ratio =
        |(a, b): (&Anchor, &Anchor)| mesh.distances.between(a.mesh, b.mesh) / a.near[b.sketch as usize].max(1e-6);
    median(pairs.map(ratio).collect()).clamp(SCALES[0], SCALES[1])
}

/// The median distortion of the distances between an anchor and others.
fn bend(mesh: &PreparedMesh, scale: f64, anchor: &Anchor, others: &[Anchor]) -> f64 {
    let distortion = |other: &Anchor| {
        (scale * anchor.near[other.sketch as usize] - mesh.distances.between(anchor.mesh, other.mesh)).abs()
    };
    median(others.iter().map(distortion).collect())
}
