//! What sticks out of a body: arms, legs, head, tail.

use serde::{Deserialize, Serialize};

use super::sampled_distances::SampledDistances;
use crate::geometry::{length, subtract};
use crate::mesh::TriangleMesh;
use crate::mesh::geodesics::Marching;
use crate::numerics::{Cancelled, Share, Watch};

/// Limbs at most.
const MOST: usize = 10;
/// A tip is farther from everything than all that is as near to it as this.
const SUMMIT: f64 = 0.12;
/// Tips are at least so far apart.
const APART: f64 = 0.28;
/// A tip lies farther up the range of mean distances than this share of it.
const RISE: f64 = 0.25;
/// Length of a limb as a share of the way to the nearest other tip.
const LENGTH: f64 = 0.47;
/// The ring about the joint lies between these shares of a limb's length, and consists of so many vertices at least.
const RING: [f64; 2] = [0.93, 1.07];
const RING_VERTICES: usize = 3;
/// Where the elbow or the knee is, as a share of the limb's length from its tip.
const ELBOW: f64 = 0.55;
/// Share of a limb's length, next to its joint, in which its weight falls to 0.
const FADE: f64 = 0.25;

/// A limb, from its tip to the joint it swings about.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Limb {
    /// The vertex farthest out.
    pub tip: u32,
    /// Its length: the geodesic distance of the joint from the tip.
    pub radius: f64,
    pub joint: [f64; 3],
    /// For each of the n vertices how far it moves with the limb, from 0 to 1.
    pub weight: Vec<f32>,
    /// Half way out: the elbow or the knee, and how far each vertex moves with what is beyond it.
    pub elbow: [f64; 3],
    pub beyond: Vec<f32>,
}

/// The limbs of a connected mesh of area 1, those that reach out farthest first, at most ten. Tips are the summits of the
/// mean of the distance fields; a single tip makes no limb.
///
/// # Errors
/// [`Cancelled`] by the watcher, asked at every possible tip.
pub fn limbs(mesh: &TriangleMesh, distances: &SampledDistances, watch: &dyn Watch) -> Result<Vec<Limb>, Cancelled> {
    let tips = tips(mesh, &mean_distances(distances, mesh.positions().len()), watch)?;
    Ok((0..tips.len()).filter_map(|i| limb(mesh, &tips, i)).collect())
}

/// For every vertex the mean of its distances from the samples that reach it.
fn mean_distances(distances: &SampledDistances, n: usize) -> Vec<f64> {
    let mean = |v: usize| {
        let reached = distances.fields.iter().map(|field| f64::from(field[v])).filter(|d| d.is_finite());
        let (sum, count) = reached.fold((0.0, 0usize), |(sum, count), d| (sum + d, count + 1));
        sum / count.max(1) as f64
    };
    (0..n).map(mean).collect()
}

/// The summits of `mean`, the highest first, each with its distance field.
fn tips(mesh: &TriangleMesh, mean: &[f64], watch: &dyn Watch) -> Result<Vec<(u32, Vec<f64>)>, Cancelled> {
    // Of equals the first vertex is the higher, so that a plateau has one summit.
    let higher = |a: usize, b: usize| mean[a] > mean[b] || mean[a] == mean[b] && a < b;
    let [low, high] = mean.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], &m| [l.min(m), h.max(m)]);
    let mut summits: Vec<usize> = among_neighbours(mesh, higher);
    summits.retain(|&v| mean[v] >= low + RISE * (high - low));
    summits.sort_by(|&a, &b| mean[b].total_cmp(&mean[a]).then(a.cmp(&b)));
    let marching = Marching::new(mesh);
    let mut tips: Vec<(u32, Vec<f64>)> = Vec::new();
    for v in summits {
        let share = Share::of(watch, tips.len(), MOST);
        share.proceed(0.0)?;
        if tips.len() == MOST {
            break;
        }
        if tips.iter().any(|(_, field)| field[v] <= APART) {
            continue;
        }
        let around = marching.distances_within(&[v as u32], SUMMIT, &share)?;
        if (0..mean.len()).all(|u| around[u] >= SUMMIT || !higher(u, v)) {
            tips.push((v as u32, marching.distances(&[v as u32], &share)?));
        }
    }
    Ok(tips)
}

/// The vertices no neighbour within [`SUMMIT`] is higher than.
fn among_neighbours(mesh: &TriangleMesh, higher: impl Fn(usize, usize) -> bool) -> Vec<usize> {
    let positions = mesh.positions();
    let mut is_summit = vec![true; positions.len()];
    for &[a, b, c] in mesh.triangles() {
        for [a, b] in [[a, b], [b, c], [c, a]].map(|edge| edge.map(|v| v as usize)) {
            if length(subtract(positions[a], positions[b])) < SUMMIT {
                is_summit[if higher(a, b) { b } else { a }] = false;
            }
        }
    }
    (0..positions.len()).filter(|&v| is_summit[v]).collect()
}

/// The limb of tip `i`, where another tip and a ring about its joint exist.
fn limb(mesh: &TriangleMesh, tips: &[(u32, Vec<f64>)], i: usize) -> Option<Limb> {
    let (tip, field) = &tips[i];
    let others = tips.iter().filter(|(other, _)| other != tip).map(|(other, _)| field[*other as usize]);
    let radius = LENGTH * others.reduce(f64::min)?;
    let joint = ring_centre(mesh, field, radius)?;
    let elbow = ring_centre(mesh, field, ELBOW * radius).unwrap_or(joint);
    let weights = |radius: f64| {
        let weight = move |d: &f64| {
            let w = ((radius - d) / (FADE * radius)).clamp(0.0, 1.0);
            (w * w * (3.0 - 2.0 * w)) as f32
        };
        field.iter().map(weight).collect()
    };
    Some(Limb { tip: *tip, radius, joint, weight: weights(radius), elbow, beyond: weights(ELBOW * radius) })
}

/// The middle of the vertices about so far from the tip, where there are several.
fn ring_centre(mesh: &TriangleMesh, field: &[f64], radius: f64) -> Option<[f64; 3]> {
    let ring: Vec<usize> =
        (0..field.len()).filter(|&v| RING[0] * radius < field[v] && field[v] < RING[1] * radius).collect();
    let mean = |k: usize| ring.iter().map(|&v| mesh.positions()[v][k]).sum::<f64>() / ring.len() as f64;
    (ring.len() >= RING_VERTICES).then(|| std::array::from_fn(mean))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::solids::{ball, sphere, star};
    use crate::numerics::Unwatched;

    fn found(mesh: &TriangleMesh) -> Vec<Limb> {
        limbs(mesh, &SampledDistances::new(mesh, 40, &Unwatched).unwrap(), &Unwatched).unwrap()
    }

    #[test]
    fn a_star_has_a_limb_for_every_ray() {
        let mesh = star(0.0);
        let limbs = found(&mesh);
        assert_eq!(limbs.len(), 5);
        for limb in &limbs {
            let tip = mesh.positions()[limb.tip as usize];
            // The middle of the ring lies inside the ray, between the tip and the middle of the body.
            assert!(length(limb.joint) < 0.8 * length(tip) && length(subtract(tip, limb.joint)) < limb.radius);
            assert_eq!(limb.weight[limb.tip as usize], 1.0);
            for other in limbs.iter().filter(|other| other.tip != limb.tip) {
                assert_eq!(limb.weight[other.tip as usize], 0.0);
            }
        }
    }

    #[test]
    fn bodies_without_limbs_are_no_trouble() {
        let tetrahedron = vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let sheet = ball(6, 8, |[x, y, z]| [x, y, 1e-9 * z]);
        for mesh in [TriangleMesh::new(positions, tetrahedron).unwrap(), sphere(12, 24), sheet] {
            assert!(found(&mesh).len() <= MOST);
        }
    }
}
