//! The plane that halves a body into two mirror images.

use kd_tree::KdTree;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde::{Deserialize, Serialize};

use super::directions::half_sphere;
use crate::geometry::frame::Frame;
use crate::geometry::{dot, unit};
use crate::numerics::nelder_mead::{self, Tolerance};

/// Points reflected to judge a plane.
const SAMPLES: usize = 500;
/// Normals tried, and how many of them are refined.
const TRIED: usize = 120;
const REFINED: usize = 4;
/// The largest distance a reflected point counts for, so that a raised arm does not tilt the plane.
const FAR: f64 = 0.15;
/// First steps of tilt (radians, nearly) and of offset.
const SPREAD: [f64; 3] = [0.15, 0.15, 0.03];
/// Where a search ends: tilts as small as the pixels of a view tell, and at the latest after so many steps.
const TOLERANCE: Tolerance = Tolerance { point: 1e-3, value: 1e-5, steps: 120 };
const SEED: u64 = 0;

/// A plane of bilateral symmetry, as good as the shape has one.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Symmetry {
    /// Of length 1; its sign means nothing.
    pub normal: [f64; 3],
    /// normal · x = offset on the plane.
    pub offset: f64,
    /// Mean distance of a reflected point from the nearest vertex, at most 0.15.
    pub asymmetry: f64,
}

impl Symmetry {
    /// How far the point lies before the plane, negative behind it.
    pub fn height(&self, point: [f64; 3]) -> f64 {
        dot(self.normal, point) - self.offset
    }

    /// The point's mirror image.
    pub fn reflect(&self, point: [f64; 3]) -> [f64; 3] {
        let height = self.height(point);
        std::array::from_fn(|i| point[i] - 2.0 * height * self.normal[i])
    }
}

/// The plane through (nearly) the centroid of the n masses that lays the vertices best on themselves: the best of 120
/// directions, four of them refined over tilt and offset.
///
/// # Errors
/// That of `ask`, which is called for every plane tried.
///
/// # Panics
/// Where there is no vertex.
pub fn plane<E>(positions: &[[f64; 3]], masses: &[f64], ask: impl Fn() -> Result<(), E>) -> Result<Symmetry, E> {
    let total: f64 = masses.iter().sum();
    let weighted = |i: usize| positions.iter().zip(masses).map(|(p, mass)| p[i] * mass).sum::<f64>();
    let centre: [f64; 3] = std::array::from_fn(|i| weighted(i) / total);
    let tree = KdTree::build_by_ordered_float(distinct(positions));
    let samples = drawn(positions, masses);
    let judged = |normal: [f64; 3], shift: f64| {
        ask()?;
        let normal = unit(normal);
        let plane = Symmetry { normal, offset: dot(normal, centre) + shift, asymmetry: 0.0 };
        Ok(Symmetry { asymmetry: asymmetry(&tree, &samples, &plane), ..plane })
    };
    let tried = half_sphere(TRIED).into_iter().map(|normal| judged(normal, 0.0));
    let mut tried: Vec<Symmetry> = tried.collect::<Result<_, E>>()?;
    tried.sort_by(|a, b| a.asymmetry.total_cmp(&b.asymmetry));
    let refined = tried[..REFINED].iter().map(|plane| {
        let frame = Frame::looking_from(plane.normal);
        let tilted = |[right, up, shift]: [f64; 3]| {
            let tilt = |i| plane.normal[i] + right * frame.right[i] + up * frame.up[i];
            judged(std::array::from_fn(tilt), shift)
        };
        tilted(nelder_mead::minimum(|p| Ok(tilted(p)?.asymmetry), [0.0; 3], SPREAD, TOLERANCE)?.0)
    });
    let refined: Vec<Symmetry> = refined.collect::<Result<_, E>>()?;
    let best = refined.into_iter().reduce(|a, b| if b.asymmetry < a.asymmetry { b } else { a });
    Ok(best.expect("several planes are refined"))
}

/// The places each once: a search in the tree visits all that stand at one place, of which a mesh whose parts meet in a point
/// may have as many as it has triangles.
fn distinct(positions: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let mut places = positions.to_vec();
    places.sort_unstable_by_key(|place| place.map(f64::to_bits));
    places.dedup();
    places
}

/// Vertices drawn with probability in proportion to mass.
fn drawn(positions: &[[f64; 3]], masses: &[f64]) -> Vec<[f64; 3]> {
    let mut random = ChaCha8Rng::seed_from_u64(SEED);
    let mut total = 0.0;
    let running: Vec<f64> = masses
        .iter()
        .map(|mass| {
            total += mass;
            total
        })
        .collect();
    let mut draw = || {
        let mark = random.random::<f64>() * total;
        // Rounding may lead past the end.
        positions[running.partition_point(|&sum| sum <= mark).min(positions.len() - 1)]
    };
    (0..SAMPLES).map(|_| draw()).collect()
}

/// Mean distance of the reflected samples from the nearest vertex, each at most [`FAR`].
fn asymmetry(tree: &KdTree<[f64; 3]>, samples: &[[f64; 3]], plane: &Symmetry) -> f64 {
    let distance = |&sample: &[f64; 3]| {
        let nearest = tree.nearest(&plane.reflect(sample));
        nearest.map_or(FAR, |found| found.squared_distance.sqrt().min(FAR))
    };
    samples.iter().map(distance).sum::<f64>() / samples.len() as f64
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::convert::Infallible;

    use super::*;
    use crate::mesh::solids::{star, turned};
    use crate::numerics::Cancelled;

    fn found(positions: &[[f64; 3]]) -> Symmetry {
        let Ok(plane) = plane(positions, &vec![1.0; positions.len()], || Ok::<_, Infallible>(()));
        plane
    }

    #[test]
    fn the_plane_of_a_body_is_found_however_it_is_turned() {
        let body = star(0.0);
        for angles in [[0.0, 0.0], [0.7, 2.1], [2.5, 0.9]] {
            let normal = turned([1.0, 0.0, 0.0], angles);
            let positions: Vec<_> =
                body.positions().iter().map(|&p| turned([p[0] + 0.3, p[1], p[2]], angles)).collect();
            let found = found(&positions);
            let along = dot(found.normal, normal);
            assert!(along.abs() > 0.9995 && found.asymmetry < 0.01, "{found:?}");
            assert!((found.offset * along.signum() - 0.3).abs() < 0.01, "{found:?}");
        }
    }

    #[test]
    fn reflecting_twice_is_doing_nothing() {
        let plane = Symmetry { normal: unit([1.0, 2.0, -2.0]), offset: 0.4, asymmetry: 0.0 };
        let (point, image) = ([0.3, -1.0, 2.0], plane.reflect([0.3, -1.0, 2.0]));
        assert!((dot(plane.normal, point) + dot(plane.normal, image) - 0.8).abs() < 1e-12);
        assert!(plane.reflect(image).iter().zip(point).all(|(a, b)| (a - b).abs() < 1e-12));
    }

    #[test]
    fn few_flat_and_repeated_points_have_a_plane() {
        let tetrahedron = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let sheet = (0..100).map(|i| [f64::from(i % 10) * 0.1, f64::from(i / 10) * 0.1, 0.0]).collect();
        for positions in [tetrahedron, sheet, vec![[0.5; 3]; 200]] {
            let Symmetry { normal, asymmetry, .. } = found(&positions);
            assert!((dot(normal, normal) - 1.0).abs() < 1e-12 && (0.0..=FAR).contains(&asymmetry));
        }
    }

    #[test]
    fn places_that_vertices_share_are_searched_once() {
        let body = star(0.0);
        let middle = [0.0; 3];
        let doubled: Vec<[f64; 3]> = body.positions().iter().flat_map(|&p| [p, middle, p]).collect();
        let places = distinct(&doubled);
        assert_eq!(places.len(), distinct(body.positions()).len() + 1);
        let masses: Vec<f64> = (0..doubled.len()).map(|v| if v % 3 == 0 { 1.0 } else { 0.0 }).collect();
        let once: Vec<[f64; 3]> = body.positions().iter().copied().chain([middle]).collect();
        let of_once: Vec<f64> = (0..once.len()).map(|v| if v < body.positions().len() { 1.0 } else { 0.0 }).collect();
        let [Ok(all), Ok(few)] =
            [(&doubled, &masses), (&once, &of_once)].map(|(p, m)| plane(p, m, || Ok::<_, Infallible>(())));
        assert_eq!(all, few);
    }

    #[test]
    fn every_plane_tried_asks() {
        let (body, asked) = (star(0.0), Cell::new(0));
        let masses = vec![1.0; body.positions().len()];
        let count = |most: usize| {
            asked.set(asked.get() + 1);
            if asked.get() > most { Err(Cancelled) } else { Ok(()) }
        };
        assert!(plane(body.positions(), &masses, || count(usize::MAX)).is_ok() && asked.get() > TRIED + 4 * REFINED);
        asked.set(0);
        // Within the simplex, too.
        assert_eq!(plane(body.positions(), &masses, || count(TRIED + 2)), Err(Cancelled));
    }
}
