//! The mesh in another pose: limbs swung about their joints.

use std::collections::BTreeSet;

use super::flat_shape::FlatShape;
use super::frame::Frame;
use super::prepared::PreparedMesh;
use super::view::View;
use super::warping::{cost, differences};
use crate::numerics::{Cancelled, Watch};

/// The largest swing, in radians.
const MOST: f64 = 1.75;
/// What a radian of swing costs.
const EFFORT: f64 = 0.0015;
/// By how much a move has to better the cost.
const GAIN: f64 = 2e-4;
/// How much less a pose may turn out to cost than the search has come to: its last passes, and distances that it bends less.
const REMAINING: f64 = 0.02;
/// The swings of the three passes in degrees, and the rounds of each.
const PASSES: [&[f64]; 3] = [&[60.0, 30.0], &[30.0], &[12.0]];
const ROUNDS: usize = 2;
/// Limbs whose joints and tips are so near in the picture may swing against each other.
const JOINTS: f64 = 0.12;
const TIPS: f64 = 0.27;
/// Starting points of the warp that are tried: every so many samples.
const EVERY: usize = 4;

/// A pose and what is seen of it.
#[derive(Clone)]
pub struct Pose {
    /// The swing of every limb in the plane of the picture, in radians.
    pub angles: Vec<f64>,
    pub view: View,
    pub cost: f64,
}

/// The positions (n × 3) of the mesh with its limbs swung in the plane of the frame.
pub fn posed(mesh: &PreparedMesh, frame: &Frame, angles: &[f64]) -> Vec<[f64; 3]> {
    let mut positions = mesh.positions.clone();
    for (limb, &angle) in mesh.limbs.iter().zip(angles) {
        if angle == 0.0 {
            continue;
        }
        let (s, c) = angle.sin_cos();
        let [jx, jy] = frame.project(limb.joint);
        for ((position, rest), &w) in positions.iter_mut().zip(&mesh.positions).zip(&limb.weight) {
            if w == 0.0 {
                continue;
            }
            let [x, y] = frame.project(*rest);
            let (x, y) = (x - jx, y - jy);
            let (dx, dy) = (c * x - s * y - x, s * x + c * y - y);
            let w = f64::from(w);
            *position = std::array::from_fn(|i| position[i] + w * (dx * frame.right[i] + dy * frame.up[i]));
        }
    }
    positions
}

/// The pose of least cost a greedy search finds from the mesh as it is: swings of single limbs and opposite swings of
/// neighbouring ones, wide ones first. None where it is not likely to come to `most`.
///
/// # Errors
/// [`Cancelled`] by the watcher, asked at every pose tried.
pub fn fitted(
    shape: &FlatShape,
    mesh: &PreparedMesh,
    view: &View,
    most: f64,
    watch: &dyn Watch,
) -> Result<Option<Pose>, Cancelled> {
    let count = mesh.limbs.len();
    let seen = |angles: Vec<f64>, limbs: Vec<usize>| {
        watch.proceed(0.0)?;
        let view = View::through(view.frame, &posed(mesh, &view.frame, &angles), &mesh.triangles, mesh.closed);
        let cost = cost(&differences(&shape.contour, &view.contour), EVERY);
        let total = cost + EFFORT * angles.iter().map(|a| a.abs()).sum::<f64>();
        Ok::<_, Cancelled>(Tried { total, limbs, pose: Pose { angles, view, cost } })
    };
    let pairs = neighbours(mesh, &view.frame);
    let mut best = Tried {
        total: 0.0,
        limbs: Vec::new(),
        pose: Pose {
            angles: vec![0.0; count],
            view: view.clone(),
            cost: cost(&differences(&shape.contour, &view.contour), 2),
        },
    };
    best.total = best.pose.cost;
    // None of the poses tried was better than the best of now.
    let mut known = BTreeSet::from([key(&best.pose.angles)]);
    for steps in PASSES {
        for _ in 0..ROUNDS {
            let mut better = Vec::new();
            for (limbs, swing) in moves(count, &pairs, steps) {
                let angles = swung(&best.pose.angles, &limbs, &swing);
                if angles.iter().any(|a| a.abs() > MOST) || !known.insert(key(&angles)) {
                    continue;
                }
                let tried = seen(angles, limbs)?;
                if tried.total < best.total - GAIN {
                    better.push(tried);
                }
            }
            if better.is_empty() {
                break;
            }
            better.sort_by(|a, b| a.total.total_cmp(&b.total));
            // All moves that touch different limbs at once, where that is better than the best one.
            let mut used = Vec::new();
            let mut angles = best.pose.angles.clone();
            for tried in &better {
                if tried.limbs.iter().all(|limb| !used.contains(limb)) {
                    tried.limbs.iter().for_each(|&limb| angles[limb] = tried.pose.angles[limb]);
                    used.extend(&tried.limbs);
                }
            }
            let another = used.len() > better[0].limbs.len() && known.insert(key(&angles));
            let together = if another { Some(seen(angles, used)?) } else { None };
            let first = better.swap_remove(0);
            best = match together {
                Some(together) if together.total < first.total => together,
                _ => first,
            };
        }
        if best.total > most + REMAINING {
            return Ok(None);
        }
    }
    Ok(Some(best.pose))
}

/// The swings as they are, and those where limbs side by side in the picture exchange their places: for every such
/// pair alone and for all of them together.
pub fn exchanges(mesh: &PreparedMesh, frame: &Frame, angles: &[f64]) -> Vec<Vec<f64>> {
    let exchanged = |pairs: &[[usize; 2]]| {
        let mut angles = angles.to_vec();
        pairs.iter().for_each(|&[i, j]| angles.swap(i, j));
        angles
    };
    let mut pairs = neighbours(mesh, frame);
    pairs.retain(|&[i, j]| angles[i] != angles[j]);
    let mut all = vec![angles.to_vec()];
    all.extend(pairs.iter().map(|&pair| exchanged(&[pair])));
    if pairs.len() > 1 {
        all.push(exchanged(&pairs));
    }
    all
}

struct Tried {
    total: f64,
    limbs: Vec<usize>,
    pose: Pose,
}

/// A pose as a key; a swing there and back leaves 0, never −0.
fn key(angles: &[f64]) -> Vec<u64> {
    angles.iter().map(|angle| angle.to_bits()).collect()
}

fn swung(angles: &[f64], limbs: &[usize], swing: &[f64]) -> Vec<f64> {
    let mut angles = angles.to_vec();
    limbs.iter().zip(swing).for_each(|(&limb, swing)| angles[limb] += swing.to_radians());
    angles
}

/// Every limb by every step both ways, every pair of neighbours against each other.
fn moves(count: usize, pairs: &[[usize; 2]], steps: &[f64]) -> Vec<(Vec<usize>, Vec<f64>)> {
    let signed = || steps.iter().flat_map(|&a| [a, -a]);
    let single = (0..count).flat_map(|limb| signed().map(move |a| (vec![limb], vec![a])));
    let double = pairs.iter().flat_map(|&pair| signed().map(move |a| (pair.to_vec(), vec![a, -a])));
    single.chain(double).collect()
}

/// Limbs that lie side by side in the picture.
fn neighbours(mesh: &PreparedMesh, frame: &Frame) -> Vec<[usize; 2]> {
    let near = |a: [f64; 3], b: [f64; 3], reach: f64| {
        let (a, b) = (frame.project(a), frame.project(b));
        (a[0] - b[0]).hypot(a[1] - b[1]) < reach
    };
    let tip = |i: usize| mesh.positions[mesh.limbs[i].tip as usize];
    let joint = |i: usize| mesh.limbs[i].joint;
    let all = (0..mesh.limbs.len()).flat_map(|i| (0..i).map(move |j| [i, j]));
    all.filter(|&[i, j]| near(joint(i), joint(j), JOINTS) && near(tip(i), tip(j), TIPS)).collect()
}
