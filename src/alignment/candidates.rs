//! The views a sketch may be drawn from, best first.

use super::flat_shape::FlatShape;
use super::prepared::PreparedMesh;
use super::view::View;
use super::warping::{Warp, cost, cost_along, differences, least_cost, warp};
use crate::mesh::{dot, subtract};
use crate::numerics::{Cancelled, Watch};

/// Views that are tried of either kind.
const CANONICAL: usize = 6;
const SPHERE: usize = 3;
/// What a view from anywhere must be better by than one along an axis of the body.
const SPHERE_PENALTY: f64 = 0.02;
/// Starting points of the warp: every so many samples.
const CANONICAL_EVERY: usize = 2;
const SPHERE_EVERY: usize = 3;

/// A view, where it is from, and how the sketch's outline lies on its own.
#[derive(Clone)]
pub struct Candidate {
    pub view: View,
    pub kind: Kind,
    pub differences: Vec<f32>,
    pub warp: Warp,
}

impl Candidate {
    pub fn new(shape: &FlatShape, view: View, kind: Kind) -> Candidate {
        let differences = differences(&shape.contour, &view.contour);
        Candidate { view, kind, warp: warp(&differences), differences }
    }

    /// What an attempt on the candidate costs at least.
    pub fn least_score(&self) -> f64 {
        cost_along(&self.warp.path, &self.differences) + self.kind.penalty()
    }
}

/// Where a candidate is from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Canonical(usize),
    Sphere(usize),
}

impl Kind {
    pub fn penalty(self) -> f64 {
        if matches!(self, Kind::Sphere(_)) { SPHERE_PENALTY } else { 0.0 }
    }
}

/// The canonical views and then those of the sphere with the least contour cost.
///
/// # Errors
/// [`Cancelled`] by the watcher.
pub fn candidates(shape: &FlatShape, mesh: &PreparedMesh, watch: &dyn Watch) -> Result<Vec<Candidate>, Cancelled> {
    let seen = |view: &View, side: usize| if side == 0 { view.clone() } else { view.from_behind() };

    let mut chosen = Vec::new();
    let ranked = nearest(shape, &mesh.canonical, 2 * mesh.canonical.len(), CANONICAL_EVERY, watch)?;
    let cost_of =
        |k: usize, side: usize| ranked.iter().find(|r| (r.1, r.2) == (k, side)).map_or(f64::INFINITY, |r| r.0);
    for &(cost, k, side) in &ranked {
        let toward = seen(&mesh.canonical[k], side).frame.toward_camera;
        let away = toward.map(|x| -x);
        // A silhouette from behind is about the same: take the side that feet and hands point to.
        let turn =
            k > 0 && cost_of(k, 1 - side) < 1.25 * cost + 0.01 && frontness(mesh, away) > frontness(mesh, toward);
        let side = if turn { 1 - side } else { side };
        if !chosen.contains(&(k, side)) && (chosen.len() < CANONICAL || k == 0) {
            chosen.push((k, side));
        }
    }
    let canonical =
        chosen.into_iter().map(|(k, side)| Candidate::new(shape, seen(&mesh.canonical[k], side), Kind::Canonical(k)));
    let sphere = nearest(shape, &mesh.sphere, SPHERE, SPHERE_EVERY, watch)?
        .into_iter()
        .map(|(_, k, side)| Candidate::new(shape, seen(&mesh.sphere[k], side), Kind::Sphere(k)));
    Ok(canonical.chain(sphere).collect())
}

/// The `count` views from either side of least cost, of equals the first: (cost, view, side).
fn nearest(
    shape: &FlatShape,
    views: &[View],
    count: usize,
    every: usize,
    watch: &dyn Watch,
) -> Result<Vec<(f64, usize, usize)>, Cancelled> {
    let mut nearest: Vec<(f64, usize, usize)> = Vec::with_capacity(count + 1);
    for (k, view) in views.iter().enumerate() {
        watch.proceed(0.0)?;
        for (side, contour) in [&view.contour, &view.contour.reversed()].into_iter().enumerate() {
            let differences = differences(&shape.contour, contour);
            if nearest.len() == count && least_cost(&differences) > nearest[count - 1].0 {
                continue;
            }
            let cost = cost(&differences, every);
            nearest.insert(nearest.partition_point(|other| other.0 <= cost), (cost, k, side));
            nearest.truncate(count);
        }
    }
    Ok(nearest)
}

/// How far the tips of the limbs lie on that side of their joints, in reaches.
fn frontness(mesh: &PreparedMesh, direction: [f64; 3]) -> f64 {
    let reach = |limb: &super::limbs::Limb| {
        dot(subtract(mesh.positions[limb.tip as usize], limb.joint), direction) / limb.radius
    };
    mesh.limbs.iter().map(reach).sum::<f64>() / mesh.limbs.len().max(1) as f64
}
