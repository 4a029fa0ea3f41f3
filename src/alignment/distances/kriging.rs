//! What landmarks say of the places around them: how far each was missed is spread over the sketch by kriging [Kri51].

use faer::Mat;

use super::by_distances::nearest;
use crate::alignment::error::AlignmentError;
use crate::alignment::prepared::sampled_distances::SampledDistances;
use crate::alignment::scene::landmarks::Landmarks;
use crate::numerics::least_squares::minimum_norm;
use crate::numerics::{Cancelled, Watch, side_by_side};

/// Samples of the mesh by the distances from which a vertex is told: farthest points, which 120 are no better for.
const SAMPLES: usize = 60;
/// The distance within the sketch at which two misses have 1/e in common, in units of √area. Of 0.2 to 1.2 what mends wrong
/// answers most with three and with eight landmarks, and right ones least.
const REACH: f64 = 0.4;
/// The share of a landmark that it has in common with no other: so that two at one place are no contradiction.
const NUGGET: f64 = 0.01;
/// An answer whose distances all change by less stays, in units of √area.
const LEAST: f64 = 0.01;
/// Landmarks that are told of, the first ones: the system is dense.
const TOLD: usize = 200;

/// The map (m vertices of the mesh) moved as the landmarks say: every vertex stands for its distances from samples of the
/// mesh, in which the landmarks' misses are interpolated with the covariance e^(−d / 0.4), d the distance within the
/// sketch; the answer is the vertex whose distances are nearest to those.
///
/// # Errors
/// [`AlignmentError`]: cancelled by the watcher, or the eigenvalues of the covariances do not converge.
pub fn kriged(
    distances: &SampledDistances,
    map: &[u32],
    landmarks: &Landmarks,
    watch: &dyn Watch,
) -> Result<Vec<u32>, AlignmentError> {
    // What does not reach everywhere tells nothing of what it does not reach.
    let reaches = |field: &&Vec<f32>| field.iter().all(|d| d.is_finite());
    let fields: Vec<&[f32]> = distances.fields.iter().take(SAMPLES).filter(reaches).map(Vec::as_slice).collect();
    let pairs = &landmarks.pairs[..landmarks.pairs.len().min(TOLD)];
    if pairs.is_empty() {
        return Ok(map.to_vec());
    }
    let covariance = |l: usize, x: u32| (-landmarks.fields[l][x as usize] / REACH).exp();
    let gram = Mat::from_fn(pairs.len(), pairs.len(), |i, j| {
        let common = 0.5 * (covariance(i, pairs[j].sketch) + covariance(j, pairs[i].sketch));
        if i == j { common + NUGGET } else { common }
    });
    let missed = Mat::from_fn(fields.len(), pairs.len(), |s, l| {
        f64::from(fields[s][pairs[l].mesh as usize] - fields[s][map[pairs[l].sketch as usize] as usize])
    });
    let told = minimum_norm(gram.as_ref(), missed.as_ref())?;

    let answer = |&x: &u32| -> Result<u32, Cancelled> {
        watch.proceed(0.0)?;
        let common: Vec<f64> = (0..pairs.len()).map(|l| covariance(l, x)).collect();
        let shift = |s: usize| (0..pairs.len()).map(|l| told[(s, l)] * common[l]).sum::<f64>();
        let shifts: Vec<f64> = (0..fields.len()).map(shift).collect();
        let now = map[x as usize];
        if shifts.iter().all(|shift| shift.abs() < LEAST) {
            return Ok(now);
        }
        let wanted = fields.iter().zip(shifts).map(|(field, shift)| f64::from(field[now as usize]) + shift);
        Ok(nearest(&fields, &wanted.collect::<Vec<_>>(), &vec![1.0; fields.len()]))
    };
    let vertices: Vec<u32> = (0..map.len() as u32).collect();
    Ok(side_by_side(&vertices, answer).into_iter().collect::<Result<Vec<u32>, Cancelled>>()?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::alignment::prepared::FlatShape;
    use crate::alignment::scene::landmarks::Pair;
    use crate::geometry::{length, subtract};
    use crate::mesh::solids::sheet;
    use crate::numerics::Unwatched;

    /// A sheet of 15 by 15 vertices answered two columns off, and its mean error after landmarks at these vertices.
    fn error_with(told: &[u32]) -> (Vec<u32>, f64) {
        let mesh = sheet(14, 14);
        let shape = FlatShape::new(&mesh, &Unwatched).unwrap();
        let distances = SampledDistances::new(&mesh, 120, &Unwatched).unwrap();
        let count = mesh.positions().len() as u32;
        let off: Vec<u32> = (0..count).map(|v| v - v % 15 + (v % 15 + 2).min(14)).collect();
        let pairs: Vec<Pair> = told.iter().map(|&v| Pair { sketch: v, mesh: v }).collect();
        let landmarks = Landmarks::new(&shape, &pairs, &Unwatched).unwrap();
        let map = kriged(&distances, &off, &landmarks, &Unwatched).unwrap();
        let positions = mesh.positions();
        let error = |(v, &to): (usize, &u32)| length(subtract(positions[v], positions[to as usize]));
        let error = map.iter().enumerate().map(error).sum::<f64>() / f64::from(count);
        (map, error)
    }

    #[test]
    fn every_landmark_mends_its_surroundings() {
        let [none, one, four, nine] =
            [&[][..], &[112], &[48, 56, 168, 176], &[32, 37, 42, 107, 112, 117, 182, 187, 192]]
                .map(|told| error_with(told).1);
        assert!(one < 0.85 * none && four < 0.6 * none && nine < 0.4 * none, "{none} {one} {four} {nine}");
        for told in [32, 42, 187] {
            assert_eq!(error_with(&[32, 42, 187]).0[told as usize], told);
        }
    }

    #[test]
    fn a_landmark_said_twice_says_no_more() {
        let (once, twice) = (error_with(&[112, 33]).0, error_with(&[112, 33, 112]).0);
        let moved = once.iter().zip(&twice).filter(|(a, b)| a != b).count();
        assert!(moved * 20 < once.len(), "{moved}");
    }
}
