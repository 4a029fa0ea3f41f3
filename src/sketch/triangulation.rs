//! The triangles of a figure: constrained Delaunay triangulation and refinement [She02] to a wanted number of vertices.

use std::f64::consts::PI;

use spade::{AngleLimit, RefinementParameters, Triangulation};

use super::arrangement::{Arrangement, Cdt};
use super::refusal::{Refusal, Warning, WarningCode};
use super::ring::signed_area;
use super::simplification::{looks, simplified};

/// A triangulated figure in the plane, triangles counter-clockwise, every point in one of them.
pub(super) struct Flat {
    pub points: Vec<[f64; 2]>,
    pub triangles: Vec<[u32; 3]>,
}

/// How much of an outline's detail and of the triangles' shape is kept.
struct Level {
    /// Corners whose triangle is smaller are left out, in squared edge lengths of the wanted triangulation.
    detail: f64,
    /// Least angle of a triangle, in degrees, where the outline's own angles allow it.
    angle: f64,
}

/// From the best to the last resort. Detail below a fifth of a triangle goes first, then the angle, so that thin parts
/// survive; only where they alone need more vertices than wanted does their form suffer too.
const LEVELS: [Level; 13] = [
    Level { detail: 0.002, angle: 25.0 },
    Level { detail: 0.005, angle: 25.0 },
    Level { detail: 0.01, angle: 25.0 },
    Level { detail: 0.02, angle: 25.0 },
    Level { detail: 0.05, angle: 25.0 },
    Level { detail: 0.1, angle: 25.0 },
    Level { detail: 0.2, angle: 25.0 },
    Level { detail: 0.2, angle: 15.0 },
    Level { detail: 0.2, angle: 5.0 },
    Level { detail: 0.2, angle: 0.0 },
    Level { detail: 1.0, angle: 0.0 },
    Level { detail: 5.0, angle: 0.0 },
    Level { detail: 25.0, angle: 0.0 },
];

/// The first levels change nothing a user would see.
const UNSEEN_DETAIL: f64 = 0.02;

/// What the outline alone may need of the wanted vertices; the rest is for even triangles.
const OUTLINE_SHARE: f64 = 0.9;

/// Relative difference from the wanted number of vertices that ends the search for the triangles' size.
const COUNT_TOLERANCE: f64 = 0.02;

/// Sizes of triangles that are tried in that search, for every level.
const MAX_TRIES: usize = 16;

/// The triangulation of the figure that `rings` bound (in the unit square, one outline and its holes, meeting nowhere)
/// with about `target` vertices, and what had to be given up for it.
///
/// # Errors
/// When the rings need more vertices than that even in their simplest form.
pub(super) fn triangulated(rings: &[Vec<[f64; 2]>], target: usize) -> Result<(Flat, Vec<Warning>), Refusal> {
    let area = area(rings);
    let edge_squared = wanted_edge_squared(area, perimeter(rings), target);
    let most_coarse = (OUTLINE_SHARE * target as f64) as usize;
    let mut looks = looks(rings);
    let mut simple = rings.to_vec();
    for level in &LEVELS {
        simple = simplified(&simple, level.detail * edge_squared, &mut looks);
        // Refinement adds points and takes none.
        if simple.iter().map(Vec::len).sum::<usize>() > most_coarse {
            continue;
        }
        let Ok(arrangement) = Arrangement::new(&simple, 1) else { continue };
        let refinement = Refinement { cdt: &arrangement.cdt, angle: level.angle, target };
        let Some(coarsest) = refinement.with_max_area(f64::INFINITY) else { continue };
        if coarsest.points.len() <= most_coarse {
            return Ok((refinement.with_target_count(coarsest, area), level.warnings()));
        }
    }
    Err(Refusal::plain(format!("the figure is too intricate for {target} vertices: ask for more")))
}

impl Level {
    fn warnings(&self) -> Vec<Warning> {
        let mut warnings = Vec::new();
        if self.detail > UNSEEN_DETAIL {
            let detail = "detail of the outline finer than the triangles was left out; more vertices keep more of it";
            warnings.push(Warning::new(WarningCode::Simplified, detail));
        }
        if self.angle < LEVELS[0].angle {
            let detail =
                format!("angles down to {}° were allowed to keep thin parts; more vertices avoid it", self.angle);
            warnings.push(Warning::new(WarningCode::ThinParts, detail));
        }
        warnings
    }
}

/// The square of the edge length of `target` points spread evenly over a figure.
fn wanted_edge_squared(area: f64, perimeter: f64, target: usize) -> f64 {
    // Even triangles of edge h have the area √3/4 h²; by Euler's formula there are 2n − b of them for b = perimeter / h
    // points on the boundary. With all n points on the boundary h is perimeter / n, so that the count is at least n.
    let even = |triangles: f64| 4.0 / 3.0_f64.sqrt() * area / triangles;
    let n = target as f64;
    let on_boundary = (perimeter / even(2.0 * n).sqrt()).min(n);
    even(2.0 * n - on_boundary)
}

fn area(rings: &[Vec<[f64; 2]>]) -> f64 {
    let mut areas = rings.iter().map(|ring| signed_area(ring).abs());
    areas.next().unwrap_or(0.0) - areas.sum::<f64>()
}

fn perimeter(rings: &[Vec<[f64; 2]>]) -> f64 {
    let length = |ring: &Vec<[f64; 2]>| -> f64 {
        let following = ring.iter().cycle().skip(1);
        ring.iter().zip(following).map(|(p, q)| (q[0] - p[0]).hypot(q[1] - p[1])).sum()
    };
    rings.iter().map(length).sum()
}

struct Refinement<'a> {
    cdt: &'a Cdt,
    angle: f64,
    target: usize,
}

impl Refinement<'_> {
    /// The refinement whose vertex count is nearest to the target, of those a bounded search over the largest
    /// triangle's area meets. `coarsest` is the one without a limit on the area.
    fn with_target_count(&self, coarsest: Flat, area: f64) -> Flat {
        let target = self.target as f64;
        let off = |flat: &Flat| (flat.points.len() as f64 - target).abs();
        // The largest triangles are about 1.8 times the mean.
        let mut limit = 1.8 * area / (2.0 * target);
        let (mut too_many, mut too_few) = (0.0, 4.0 * area);
        let mut best = coarsest;
        for _ in 0..MAX_TRIES {
            let count = match self.with_max_area(limit) {
                Some(flat) => {
                    let count = flat.points.len() as f64;
                    if off(&flat) < off(&best) {
                        best = flat;
                    }
                    count
                }
                None => 2.0 * target,
            };
            if off(&best) <= COUNT_TOLERANCE * target {
                break;
            }
            *(if count > target { &mut too_many } else { &mut too_few }) = limit;
            // The count goes about as the inverse of the area; where that leads out of the bracket it is halved.
            let guess = limit * count / target;
            let middle = if too_many > 0.0 { f64::sqrt(too_many * too_few) } else { 0.5 * limit };
            limit = if guess > too_many && guess < too_few { guess } else { middle };
        }
        best
    }

    /// The refinement with no triangle larger than `max_area`; none where it takes far more vertices than wanted.
    fn with_max_area(&self, max_area: f64) -> Option<Flat> {
        let mut cdt = self.cdt.clone();
        let result = cdt.refine(
            RefinementParameters::new()
                .exclude_outer_faces(true)
                .with_angle_limit(AngleLimit::from_rad(self.angle * PI / 180.0))
                .with_max_allowed_area(max_area)
                .with_max_additional_vertices(2 * self.target),
        );
        let mut inside = vec![true; cdt.num_all_faces()];
        result.excluded_faces.iter().for_each(|face| inside[face.index()] = false);
        result.refinement_complete.then(|| Flat::of(&cdt, &inside))
    }
}

impl Flat {
    /// The faces for which `inside` holds, and their vertices in the order of first use.
    fn of(cdt: &Cdt, inside: &[bool]) -> Self {
        let mut number = vec![u32::MAX; cdt.num_vertices()];
        let mut flat = Self { points: Vec::new(), triangles: Vec::new() };
        for face in cdt.inner_faces().filter(|face| inside[face.index()]) {
            flat.triangles.push(face.vertices().map(|vertex| {
                let number = &mut number[vertex.index()];
                if *number == u32::MAX {
                    *number = flat.points.len() as u32;
                    let spade::Point2 { x, y } = vertex.position();
                    flat.points.push([x, y]);
                }
                *number
            }));
        }
        flat
    }
}
