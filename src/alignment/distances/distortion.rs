//! How far a point map bends the distances within the sketch.

use crate::alignment::prepared::FlatShape;
use crate::alignment::prepared::sampled_distances::{Place, SampledDistances};
use crate::numerics::median;

/// The distortion a pair of points counts with at most.
const MOST: f64 = 0.4;
/// Within which a length of the sketch may be longer or shorter on the mesh; both have area 1, but a sketch shows one
/// side.
pub const SCALES: [f64; 2] = [0.45, 0.9];

/// The distortion of a point map between the sketch's samples.
#[derive(Clone, Debug)]
pub struct Distortion {
    /// Mean of min(|s d_sketch − d_mesh|, 0.4) over the pairs of samples.
    pub mean: f64,
    /// s, a length of the mesh by that of the sketch.
    pub scale: f64,
    /// The mean over the pairs of each sample.
    pub of_samples: Vec<f64>,
}

/// The distortion of the map (m vertices of the mesh).
pub fn distortion(shape: &FlatShape, distances: &SampledDistances, map: &[u32]) -> Distortion {
    let count = shape.samples.len();
    let places: Vec<Place> = shape.samples.iter().map(|&sample| distances.at(map[sample as usize])).collect();
    let mut pairs = Vec::with_capacity(count * count / 2);
    for i in 0..count {
        for j in 0..i {
            let flat = shape.distances[i][shape.samples[j] as usize];
            let solid = places[i].to(&places[j]);
            pairs.push((i, j, flat, solid));
        }
    }
    let scale = median(pairs.iter().map(|p| p.3 / p.2.max(1e-6)).collect()).clamp(SCALES[0], SCALES[1]);
    let mut of_samples = vec![0.0; count];
    for &(i, j, flat, solid) in &pairs {
        let distortion = (scale * flat - solid).abs().min(MOST);
        of_samples[i] += distortion;
        of_samples[j] += distortion;
    }
    let total: f64 = of_samples.iter().sum();
    of_samples.iter_mut().for_each(|d| *d /= count as f64);
    Distortion { mean: total / (2.0 * pairs.len().max(1) as f64), scale, of_samples }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::solids::sheet;
    use crate::numerics::Unwatched;

    #[test]
    fn a_shape_on_itself_has_no_distortion_but_that_of_the_estimate() {
        let mesh = sheet(14, 14);
        let shape = FlatShape::new(&mesh, &Unwatched).unwrap();
        let distances = SampledDistances::new(&mesh, 120, &Unwatched).unwrap();
        let map: Vec<u32> = (0..shape.positions.len() as u32).collect();
        let itself = distortion(&shape, &distances, &map);
        let reversed: Vec<u32> = map.iter().rev().copied().collect();
        let shuffled: Vec<u32> = map.iter().map(|v| v * 37 % map.len() as u32).collect();
        // The largest scale is 0.9, of a shape on itself 1 is the true one.
        assert_eq!(itself.scale, SCALES[1]);
        assert!(itself.mean < 0.06, "{}", itself.mean);
        assert!((distortion(&shape, &distances, &reversed).mean - itself.mean).abs() < 0.01);
        assert!(distortion(&shape, &distances, &shuffled).mean > 0.15);
    }
}
