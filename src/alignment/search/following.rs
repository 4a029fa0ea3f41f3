//! The mesh put into the pose of a sketch by what lies on what: each limb is turned, bent and stretched as its part of the
//! outline is by the warp, which gives other places for the outlines to lie on each other, and so on.

use super::pose::{Move, Pose, posed};
use crate::alignment::contour::SAMPLES;
use crate::alignment::contour::view::View;
use crate::alignment::contour::warping::warp;
use crate::alignment::scene::Scene;
use crate::alignment::search::differences::differences;
use crate::numerics::Cancelled;

/// Rounds of warp and pose.
const ROUNDS: usize = 4;
/// The cost of a pair of samples at which its weight has fallen to 1/e.
const SIGMA: f64 = 0.15;
/// Samples of a limb, and of the part of it on one side of the elbow, from which a turn is told.
const FEWEST: usize = 4;
/// Vertices among which that of a sample is looked for.
const VERTICES: usize = 5000;
/// The share of its weight that a pair on a limb loses where the whole mesh is laid on the sketch: limbs are what moves then.
const ON_LIMB: f64 = 0.8;
/// How far a move of one round may go: radians, logarithms.
const TURN: f64 = 1.6;
const GROWTH: f64 = 0.5;

/// The pose that the warps of the outlines lead to, starting from the mesh as it is; what is best on the way.
///
/// # Errors
/// [`Cancelled`] by the watcher, asked at every pose tried.
pub fn followed(scene: &Scene<'_>, view: &View) -> Result<Pose, Cancelled> {
    let mut now = Tried::new(scene, view.clone(), vec![Move::default(); scene.mesh.limbs.len()]);
    let mut best = now.clone();
    for _ in 0..ROUNDS {
        let mut next: Option<Tried> = None;
        for bent in [false, true] {
            scene.watch.proceed(0.0)?;
            let moves = now.led(scene, bent);
            if moves == now.pose.moves {
                continue;
            }
            let positions = posed(scene.mesh, &view.frame, &moves);
            let view = View::through(view.frame, &positions, &scene.mesh.triangles, scene.mesh.closed);
            let tried = Tried::new(scene, view, moves);
            if next.as_ref().is_none_or(|next| tried.pose.total() < next.pose.total()) {
                next = Some(tried);
            }
        }
        let Some(next) = next else { break };
        now = next;
        if now.pose.total() < best.pose.total() {
            best = now.clone();
        }
    }
    Ok(best.pose)
}

#[derive(Clone)]
struct Tried {
    pose: Pose,
    /// Samples of the sketch, of the view, and the weight of the pair.
    pairs: Vec<(usize, usize, f64)>,
}

impl Tried {
    fn new(scene: &Scene<'_>, view: View, moves: Vec<Move>) -> Tried {
        let differences = differences(scene, &view);
        let warp = warp(&differences);
        let weight = |i: usize, j: usize| (-(f64::from(differences[i * SAMPLES + j]) / SIGMA).powi(2)).exp();
        let pairs = warp.path.iter().map(|&(i, j)| (i, j, weight(i, j))).collect();
        Tried { pose: Pose { moves, view, cost: warp.cost }, pairs }
    }

    /// The moves that bring every limb to where the warp has it.
    fn led(&self, scene: &Scene<'_>, bent: bool) -> Vec<Move> {
        let (mesh, frame) = (scene.mesh, &self.pose.view.frame);
        let positions = posed(mesh, frame, &self.pose.moves);
        let step = positions.len().div_ceil(VERTICES).max(1);
        let flat: Vec<(usize, [f64; 2])> =
            (0..positions.len()).step_by(step).map(|v| (v, frame.project(positions[v]))).collect();
        let nearest = |at: &[f64; 2]| {
            let squared = |p: &[f64; 2]| (p[0] - at[0]).powi(2) + (p[1] - at[1]).powi(2);
            flat.iter().min_by(|a, b| squared(&a.1).total_cmp(&squared(&b.1))).map_or(0, |&(v, _)| v)
        };
        let curve = &self.pose.view.contour.curve;
        let vertices: Vec<usize> = curve.iter().map(nearest).collect();
        let on_limb = |j: usize| mesh.limbs.iter().map(|limb| f64::from(limb.weight[vertices[j]])).fold(0.0, f64::max);
        let own = &scene.shape.contour.curve;
        let trunk: Vec<Match> = self
            .pairs
            .iter()
            .map(|&(i, j, weight)| Match { from: own[i], to: curve[j], weight: weight * (1.0 - ON_LIMB * on_limb(j)) })
            .collect();
        let laid = Fit::of(&trunk);
        let matches = |of: &dyn Fn(usize) -> f64| -> Vec<Match> {
            let all = self.pairs.iter().map(|&(i, j, weight)| Match {
                from: curve[j],
                to: laid.apply(own[i]),
                weight: weight * of(vertices[j]),
            });
            all.filter(|m| m.weight > 0.02).collect()
        };
        let mut moves = self.pose.moves.clone();
        for (limb, step) in mesh.limbs.iter().zip(&mut moves) {
            let (weight, beyond) = (|v: usize| f64::from(limb.weight[v]), |v: usize| f64::from(limb.beyond[v]));
            let whole = matches(&|v| weight(v));
            if whole.len() < FEWEST {
                continue;
            }
            let base = matches(&|v| if (0.05..0.95).contains(&weight(v)) { 1.0 } else { 0.0 });
            let pivot = Pivot::of(&base, frame.project(limb.joint));
            let inner = matches(&|v| weight(v) * (1.0 - beyond(v)));
            let outer = matches(&beyond);
            let (swing, bend) = if bent && inner.len() >= FEWEST && outer.len() >= FEWEST {
                let swing = turn_about(&inner, &pivot);
                (swing, wrapped(Fit::of(&outer).angle() - swing))
            } else {
                (turn_about(&whole, &pivot), 0.0)
            };
            let growth = growth_about(&whole, &pivot);
            let next = step.added(Move {
                swing: swing.clamp(-TURN, TURN),
                bend: bend.clamp(-TURN, TURN),
                stretch: growth.clamp(-GROWTH, GROWTH),
            });
            *step = next.held();
        }
        moves
    }
}

/// A point, and where the warp has it.
#[derive(Clone, Copy)]
struct Match {
    from: [f64; 2],
    to: [f64; 2],
    weight: f64,
}

/// The point a limb turns about, and where the warp has it.
struct Pivot {
    from: [f64; 2],
    to: [f64; 2],
}

impl Pivot {
    fn of(base: &[Match], joint: [f64; 2]) -> Pivot {
        let total: f64 = base.iter().map(|m| m.weight).sum();
        if total < 0.5 {
            return Pivot { from: joint, to: joint };
        }
        let mean = |at: fn(&Match) -> [f64; 2]| {
            [0, 1].map(|axis| base.iter().map(|m| m.weight * at(m)[axis]).sum::<f64>() / total)
        };
        Pivot { from: mean(|m| m.from), to: mean(|m| m.to) }
    }
}

fn turn_about(matches: &[Match], pivot: &Pivot) -> f64 {
    let (mut cos, mut sin) = (0.0, 0.0);
    for m in matches {
        let ([x, y], [u, v]) = (minus(m.from, pivot.from), minus(m.to, pivot.to));
        cos += m.weight * (x * u + y * v);
        sin += m.weight * (x * v - y * u);
    }
    sin.atan2(cos)
}

fn growth_about(matches: &[Match], pivot: &Pivot) -> f64 {
    let (mut before, mut after) = (0.0, 0.0);
    for m in matches {
        let ([x, y], [u, v]) = (minus(m.from, pivot.from), minus(m.to, pivot.to));
        before += m.weight * (x * x + y * y);
        after += m.weight * (u * u + v * v);
    }
    0.5 * (after.max(1e-9) / before.max(1e-9)).ln()
}

fn minus(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    [a[0] - b[0], a[1] - b[1]]
}

fn wrapped(angle: f64) -> f64 {
    let (sin, cos) = angle.sin_cos();
    sin.atan2(cos)
}

/// p ↦ scale · R p + shift.
struct Fit {
    linear: [f64; 2],
    from: [f64; 2],
    to: [f64; 2],
}

impl Fit {
    fn of(matches: &[Match]) -> Fit {
        let total: f64 = matches.iter().map(|m| m.weight).sum::<f64>().max(1e-9);
        let mean = |at: fn(&Match) -> [f64; 2]| {
            [0, 1].map(|axis| matches.iter().map(|m| m.weight * at(m)[axis]).sum::<f64>() / total)
        };
        let (from, to) = (mean(|m| m.from), mean(|m| m.to));
        let (mut cos, mut sin, mut spread) = (0.0, 0.0, 0.0);
        for m in matches {
            let ([x, y], [u, v]) = (minus(m.from, from), minus(m.to, to));
            cos += m.weight * (x * u + y * v);
            sin += m.weight * (x * v - y * u);
            spread += m.weight * (x * x + y * y);
        }
        Fit { linear: [cos, sin].map(|x| x / spread.max(1e-9)), from, to }
    }

    fn angle(&self) -> f64 {
        self.linear[1].atan2(self.linear[0])
    }

    fn apply(&self, p: [f64; 2]) -> [f64; 2] {
        let ([x, y], [c, s]) = (minus(p, self.from), self.linear);
        [self.to[0] + c * x - s * y, self.to[1] + s * x + c * y]
    }
}
