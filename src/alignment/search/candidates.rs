//! The views a sketch may be drawn from, best first.

use crate::alignment::contour::view::View;
use crate::alignment::contour::warping::{Warp, cost, warp};
use crate::alignment::prepared::PreparedMesh;
use crate::alignment::prepared::limbs::Limb;
use crate::alignment::scene::Scene;
use crate::alignment::search::differences::differences;
use crate::geometry::{dot, subtract};
use crate::numerics::{Cancelled, side_by_side};

/// Views that are tried of either kind.
const CANONICAL: usize = 14;
const SPHERE: usize = 3;
/// Starting points of the warp: every so many samples.
const CANONICAL_EVERY: usize = 2;
const SPHERE_EVERY: usize = 3;
/// How much worse the other side of a view may be and still fit about as well: so many times the contour cost, and so much more,
/// which counts where both cost next to nothing.
const WORSE: f64 = 1.25;
const WORSE_BY: f64 = 0.01;

/// A view, where it is from, and how the sketch's outline lies on its own.
#[derive(Clone)]
pub struct Candidate {
    pub view: View,
    pub kind: Kind,
    pub differences: Vec<f32>,
    pub warp: Warp,
}

impl Candidate {
    pub fn new(scene: &Scene<'_>, view: View, kind: Kind) -> Candidate {
        let differences = differences(scene, &view);
        Candidate { view, kind, warp: warp(&differences), differences }
    }
}

/// Where a candidate is from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Canonical(usize),
    Sphere(usize),
}

/// The canonical views and then those of the sphere with the least contour cost.
///
/// # Errors
/// [`Cancelled`] by the watcher.
pub fn candidates(scene: &Scene<'_>) -> Result<Vec<Candidate>, Cancelled> {
    let mut candidates = canonical(scene)?;
    let sphere = nearest(scene, &scene.mesh.sphere, SPHERE, SPHERE_EVERY)?;
    let views = sphere.into_iter().map(|(_, k, side)| (seen(&scene.mesh.sphere[k], side), Kind::Sphere(k)));
    candidates.extend(views.map(|(view, kind)| Candidate::new(scene, view, kind)));
    Ok(candidates)
}

/// The canonical views with the least contour cost.
///
/// # Errors
/// [`Cancelled`] by the watcher.
pub fn canonical(scene: &Scene<'_>) -> Result<Vec<Candidate>, Cancelled> {
    let mesh = scene.mesh;
    let mut chosen = Vec::new();
    let ranked = nearest(scene, &mesh.canonical, 2 * mesh.canonical.len(), CANONICAL_EVERY)?;
    let cost_of =
        |k: usize, side: usize| ranked.iter().find(|r| (r.1, r.2) == (k, side)).map_or(f64::INFINITY, |r| r.0);
    for &(cost, k, side) in &ranked {
        let toward = seen(&mesh.canonical[k], side).frame.toward_camera;
        let away = toward.map(|x| -x);
        // A silhouette from behind is about the same: take the side that feet and hands point to.
        let as_well = cost_of(k, 1 - side) < WORSE * cost + WORSE_BY;
        let turn = k > 0 && as_well && frontness(mesh, away) > frontness(mesh, toward);
        let side = if turn { 1 - side } else { side };
        if !chosen.contains(&(k, side)) && (chosen.len() < CANONICAL || k == 0) {
            chosen.push((k, side));
        }
    }
    let views = chosen.into_iter().map(|(k, side)| (seen(&mesh.canonical[k], side), Kind::Canonical(k)));
    Ok(views.map(|(view, kind)| Candidate::new(scene, view, kind)).collect())
}

/// A view, from behind where the side is not 0.
fn seen(view: &View, side: usize) -> View {
    if side == 0 { view.clone() } else { view.from_behind() }
}

/// The `count` views from either side of least cost, of equals the first: (cost, view, side).
fn nearest(
    scene: &Scene<'_>,
    views: &[View],
    count: usize,
    every: usize,
) -> Result<Vec<(f64, usize, usize)>, Cancelled> {
    let cost_of = |&(k, side): &(usize, usize)| {
        scene.watch.proceed(0.0)?;
        Ok((cost(&differences(scene, &seen(&views[k], side)), every), k, side))
    };
    let sides: Vec<(usize, usize)> = (0..views.len()).flat_map(|k| [(k, 0), (k, 1)]).collect();
    let costs = side_by_side(&sides, cost_of);
    let mut nearest = costs.into_iter().collect::<Result<Vec<_>, Cancelled>>()?;
    nearest.sort_by(|a, b| a.0.total_cmp(&b.0));
    nearest.truncate(count);
    Ok(nearest)
}

/// How far the tips of the limbs lie on that side of their joints, in reaches.
fn frontness(mesh: &PreparedMesh, direction: [f64; 3]) -> f64 {
    let reach = |limb: &Limb| dot(subtract(mesh.positions[limb.tip as usize], limb.joint), direction) / limb.radius;
    mesh.limbs.iter().map(reach).sum::<f64>() / mesh.limbs.len().max(1) as f64
}
