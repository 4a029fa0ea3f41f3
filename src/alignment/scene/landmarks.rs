//! What the user knows: points of the sketch whose vertex of the mesh is given.

use crate::alignment::contour::SAMPLES;
use crate::alignment::contour::view::View;
use crate::alignment::prepared::sampled_distances::Place;
use crate::alignment::prepared::{FlatShape, PreparedMesh};
use crate::numerics::{Cancelled, Watch, median};

/// How much a difference of distances, in units of √area, counts beside the difference of two samples, and the largest
/// that counts.
const PRICE: f64 = 1.0;
const MOST: f64 = 0.4;
/// The distance from a landmark, on the mesh, at which what it tells counts 1/e.
const REACH: f64 = 0.3;

/// The distance from a landmark at which its answer misses it.
pub const MISSED: f64 = 0.08;

/// The median distortion of the distances to the others from which a landmark is at odds with them.
const ODD: f64 = 0.2;

/// A vertex of the sketch and the vertex of the mesh it is known to be.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Pair {
    pub sketch: u32,
    pub mesh: u32,
}

/// Landmarks, and the distances from them within the sketch.
pub struct Landmarks {
    pub pairs: Vec<Pair>,
    /// For every landmark its distance to each of the m vertices of the sketch.
    pub fields: Vec<Vec<f64>>,
    /// For every sample of the sketch's contour the vertex of the outline nearest to it.
    outline: Vec<u32>,
}

impl Landmarks {
    /// # Errors
    /// [`Cancelled`] by the watcher, asked at every landmark.
    pub fn new(shape: &FlatShape, pairs: &[Pair], watch: &dyn Watch) -> Result<Landmarks, Cancelled> {
        let rim = || shape.outline.iter().map(|&v| (v, shape.positions[v as usize]));
        let of = |&sample: &[f64; 2]| nearest(rim(), sample);
        let outline = if pairs.is_empty() { Vec::new() } else { shape.contour.curve.iter().map(of).collect() };
        let field = |(i, pair): (usize, &Pair)| {
            watch.proceed(i as f64 / pairs.len() as f64)?;
            shape.distances_from(pair.sketch, watch)
        };
        let fields = pairs.iter().enumerate().map(field).collect::<Result<_, Cancelled>>()?;
        Ok(Landmarks { pairs: pairs.to_vec(), fields, outline })
    }

    /// What has to be added to the differences (110 × 110) between the sketch's and the view's contour: how far the
    /// distances of the two samples from the landmarks disagree, `scale` being a length of the mesh by that of the
    /// sketch. `positions` (n × 3) are those that are seen.
    pub fn bias(&self, differences: &mut [f32], mesh: &PreparedMesh, view: &View, positions: &[[f64; 3]], scale: f64) {
        let flat: Vec<[f64; 2]> = positions.iter().map(|&p| view.frame.project(p)).collect();
        let rim: Vec<u32> = view.contour.curve.iter().map(|&at| nearest((0..).zip(flat.iter().copied()), at)).collect();
        let away: Vec<Vec<f64>> =
            self.pairs.iter().map(|pair| rim.iter().map(|&v| mesh.distances.between(pair.mesh, v)).collect()).collect();
        for i in 0..SAMPLES {
            let near: Vec<f64> = self.fields.iter().map(|field| scale * field[self.outline[i] as usize]).collect();
            let weights: Vec<f64> = near.iter().map(|d| (-d / REACH).exp()).collect();
            for j in 0..SAMPLES {
                let disagreement = |l: usize| weights[l] * (near[l] - away[l][j]).abs().min(MOST);
                differences[i * SAMPLES + j] += (PRICE * (0..near.len()).map(disagreement).sum::<f64>()) as f32;
            }
        }
    }

    /// The landmarks whose distances on the mesh from most others are not those in the sketch, `scale` being a length of
    /// the mesh by that of the sketch.
    pub fn at_odds(&self, mesh: &PreparedMesh, scale: f64) -> Vec<usize> {
        let places: Vec<Place> = self.pairs.iter().map(|pair| mesh.distances.at(pair.mesh)).collect();
        let bend = |i: usize, j: usize| {
            (scale * self.fields[i][self.pairs[j].sketch as usize] - places[i].to(&places[j])).abs()
        };
        let others = |i: usize| (0..places.len()).filter(move |&j| j != i);
        (0..places.len()).filter(|&i| median(others(i).map(|j| bend(i, j)).collect()) > ODD).collect()
    }

    /// The distance on the mesh of every landmark from its answer in a map.
    pub fn misses(&self, mesh: &PreparedMesh, map: &[u32]) -> Vec<f64> {
        self.pairs.iter().map(|pair| mesh.distances.between(map[pair.sketch as usize], pair.mesh)).collect()
    }

    /// Whether a map misses one of them.
    pub fn contradict(&self, mesh: &PreparedMesh, map: &[u32]) -> bool {
        self.misses(mesh, map).into_iter().any(|miss| miss > MISSED)
    }

    /// Mean distance on the mesh, each at most 0.4, of the landmarks from their answers in a map.
    pub fn astray(&self, mesh: &PreparedMesh, map: &[u32]) -> f64 {
        let misses = self.misses(mesh, map);
        misses.iter().map(|miss| miss.min(MOST)).sum::<f64>() / misses.len().max(1) as f64
    }
}

/// The first of the nearest of the points, which are vertices and their places; 0 of none.
fn nearest(points: impl Iterator<Item = (u32, [f64; 2])>, at: [f64; 2]) -> u32 {
    let squared = |p: &[f64; 2]| (p[0] - at[0]).powi(2) + (p[1] - at[1]).powi(2);
    points.min_by(|(_, a), (_, b)| squared(a).total_cmp(&squared(b))).map_or(0, |(v, _)| v)
}
