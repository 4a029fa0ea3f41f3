//! What the user knows: points of the sketch whose vertex of the mesh is given.

use super::Pair;
use super::contour::SAMPLES;
use super::flat_shape::FlatShape;
use super::prepared::PreparedMesh;
use super::view::View;

/// How much a difference of distances, in units of √area, counts beside the difference of two samples, and the largest
/// that counts.
const PRICE: f64 = 1.0;
const MOST: f64 = 0.4;
/// The distance from a landmark, on the mesh, at which what it tells counts 1/e.
const REACH: f64 = 0.3;

/// Landmarks, and the distances from them within the sketch.
pub(super) struct Landmarks {
    pub pairs: Vec<Pair>,
    /// For every landmark its distance to each of the m vertices of the sketch.
    pub fields: Vec<Vec<f64>>,
    /// For every sample of the sketch's contour the vertex of the outline nearest to it.
    outline: Vec<u32>,
}

impl Landmarks {
    pub fn new(shape: &FlatShape, pairs: &[Pair]) -> Landmarks {
        let nearest = |sample: &[f64; 2]| {
            let squared = |v: &u32| {
                let p = shape.positions[*v as usize];
                (p[0] - sample[0]).powi(2) + (p[1] - sample[1]).powi(2)
            };
            shape.outline.iter().copied().min_by(|a, b| squared(a).total_cmp(&squared(b))).unwrap_or(0)
        };
        let outline = if pairs.is_empty() { Vec::new() } else { shape.contour.curve.iter().map(nearest).collect() };
        let fields = pairs.iter().map(|pair| shape.distances_from(pair.sketch)).collect();
        Landmarks { pairs: pairs.to_vec(), fields, outline }
    }

    pub fn is_empty(&self) -> bool {
        self.pairs.is_empty()
    }

    /// What has to be added to the differences (110 × 110) between the sketch's and the view's contour: how far the
    /// distances of the two samples from the landmarks disagree, `scale` being a length of the mesh by that of the
    /// sketch. `positions` (n × 3) are those that are seen.
    pub fn bias(&self, differences: &mut [f32], mesh: &PreparedMesh, view: &View, positions: &[[f64; 3]], scale: f64) {
        let flat: Vec<[f64; 2]> = positions.iter().map(|&p| view.frame.project(p)).collect();
        let rim: Vec<u32> = view.contour.curve.iter().map(|&at| nearest(&flat, at)).collect();
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

    /// Mean disagreement, each at most 0.4, of the distances from the landmarks to the samples and their answers.
    pub fn bent(&self, shape: &FlatShape, mesh: &PreparedMesh, map: &[u32], scale: f64) -> f64 {
        let disagreement = |l: usize, x: u32| {
            let wanted = scale * self.fields[l][x as usize];
            (wanted - mesh.distances.between(map[x as usize], self.pairs[l].mesh)).abs().min(MOST)
        };
        let of = |l: usize| shape.samples.iter().map(|&x| disagreement(l, x)).sum::<f64>();
        (0..self.pairs.len()).map(of).sum::<f64>() / (self.pairs.len() * shape.samples.len()).max(1) as f64
    }

    /// Mean distance on the mesh, each at most 0.4, of the landmarks from their answers in a map.
    pub fn astray(&self, mesh: &PreparedMesh, map: &[u32]) -> f64 {
        let distance = |pair: &Pair| mesh.distances.between(map[pair.sketch as usize], pair.mesh).min(MOST);
        self.pairs.iter().map(distance).sum::<f64>() / self.pairs.len().max(1) as f64
    }
}

fn nearest(points: &[[f64; 2]], at: [f64; 2]) -> u32 {
    let squared = |v: usize| (points[v][0] - at[0]).powi(2) + (points[v][1] - at[1]).powi(2);
    (0..points.len()).fold(0, |best, v| if squared(v) < squared(best) { v } else { best }) as u32
}
