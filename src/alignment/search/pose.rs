//! The mesh in another pose: limbs swung about their joints.

use std::collections::BTreeSet;

use crate::alignment::contour::view::View;
use crate::alignment::contour::warping::cost;
use crate::alignment::prepared::PreparedMesh;
use crate::alignment::scene::Scene;
use crate::alignment::search::differences::differences;
use crate::geometry::frame::Frame;
use crate::numerics::{Cancelled, side_by_side};

/// The largest swing and bend, in radians, and the largest change of a length, as a logarithm.
const MOST: f64 = 1.75;
const SHORTEST: f64 = -1.0;
const LONGEST: f64 = 0.6;
/// What a radian of swing costs, and a limb e times as long.
pub const EFFORT: f64 = 0.0015;
/// By how much a move has to better the cost.
const GAIN: f64 = 2e-4;
/// The passes of the search, and the rounds of each.
const PASSES: [Pass; 2] =
    [Pass { swings: &[30.0], bend: 50.0, stretch: 0.25 }, Pass { swings: &[12.0], bend: 25.0, stretch: 0.12 }];
const ROUNDS: usize = 2;
/// Limbs whose joints and tips are so near in the picture may swing against each other.
const JOINTS: f64 = 0.12;
const TIPS: f64 = 0.27;
/// Starting points of the warp that are tried: every so many samples.
const EVERY: usize = 4;

/// The steps of a pass: swings and bends in degrees, and the logarithm of a change of length.
struct Pass {
    swings: &'static [f64],
    bend: f64,
    stretch: f64,
}

/// How a limb is moved in the plane of the picture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Move {
    /// About its joint, in radians.
    pub swing: f64,
    /// What is beyond the elbow, about the elbow, in radians.
    pub bend: f64,
    /// The logarithm of its length by that at rest: another build, or a limb that points to the camera or away from it.
    pub stretch: f64,
}

impl Move {
    pub fn added(self, other: Move) -> Move {
        Move { swing: self.swing + other.swing, bend: self.bend + other.bend, stretch: self.stretch + other.stretch }
    }

    /// The move, held within what a limb can do.
    pub fn held(self) -> Move {
        Move {
            swing: self.swing.clamp(-MOST, MOST),
            bend: self.bend.clamp(-MOST, MOST),
            stretch: self.stretch.clamp(SHORTEST, LONGEST),
        }
    }

    /// Whether a limb goes so far.
    fn is_possible(self) -> bool {
        self.swing.abs() <= MOST && self.bend.abs() <= MOST && (SHORTEST..=LONGEST).contains(&self.stretch)
    }

    /// How far it goes: radians and logarithms alike.
    pub fn extent(self) -> f64 {
        self.swing.abs() + self.bend.abs() + self.stretch.abs()
    }
}

/// A pose and what is seen of it.
#[derive(Clone)]
pub struct Pose {
    /// A move for every limb.
    pub moves: Vec<Move>,
    pub view: View,
    /// What the outlines cost.
    pub cost: f64,
}

impl Pose {
    fn seen(scene: &Scene<'_>, frame: Frame, moves: Vec<Move>) -> Pose {
        let positions = posed(scene.mesh, &frame, &moves);
        let view = View::through(frame, &positions, &scene.mesh.triangles, scene.mesh.closed);
        Pose { cost: cost(&differences(scene, &view), EVERY), moves, view }
    }

    /// What the pose costs, its moves included.
    pub fn total(&self) -> f64 {
        self.cost + EFFORT * self.moves.iter().map(|step| step.extent()).sum::<f64>()
    }
}

/// The positions (n × 3) of the mesh with its limbs moved in the plane of the frame.
pub fn posed(mesh: &PreparedMesh, frame: &Frame, moves: &[Move]) -> Vec<[f64; 3]> {
    let mut positions = mesh.positions.clone();
    for (limb, &step) in mesh.limbs.iter().zip(moves) {
        if step == Move::default() {
            continue;
        }
        let (joint, elbow) = (frame.project(limb.joint), frame.project(limb.elbow));
        let tip = frame.project(mesh.positions[limb.tip as usize]);
        let axis = direction(joint, tip);
        let (swing, bend, grown) = (step.swing.sin_cos(), step.bend.sin_cos(), step.stretch.exp() - 1.0);
        for (v, &w) in limb.weight.iter().enumerate().filter(|&(_, &w)| w > 0.0) {
            let rest = frame.project(mesh.positions[v]);
            let bent = blended(rest, turned(rest, elbow, bend), limb.beyond[v]);
            let along = grown * ((bent[0] - joint[0]) * axis[0] + (bent[1] - joint[1]) * axis[1]);
            let longer = [bent[0] + along * axis[0], bent[1] + along * axis[1]];
            let placed = blended(rest, turned(longer, joint, swing), w);
            let [dx, dy] = [placed[0] - rest[0], placed[1] - rest[1]];
            positions[v] = std::array::from_fn(|i| positions[v][i] + dx * frame.right[i] + dy * frame.up[i]);
        }
    }
    positions
}

fn direction(from: [f64; 2], to: [f64; 2]) -> [f64; 2] {
    let [x, y] = [to[0] - from[0], to[1] - from[1]];
    let length = x.hypot(y).max(f64::MIN_POSITIVE);
    [x / length, y / length]
}

fn turned(point: [f64; 2], about: [f64; 2], (sin, cos): (f64, f64)) -> [f64; 2] {
    let [x, y] = [point[0] - about[0], point[1] - about[1]];
    [about[0] + cos * x - sin * y, about[1] + sin * x + cos * y]
}

fn blended(a: [f64; 2], b: [f64; 2], weight: f32) -> [f64; 2] {
    let w = f64::from(weight);
    [a[0] + w * (b[0] - a[0]), a[1] + w * (b[1] - a[1])]
}

/// The pose of least cost a greedy search finds from another: moves of single limbs and opposite swings of neighbouring
/// ones, wide ones first.
///
/// # Errors
/// [`Cancelled`] by the watcher, asked at every pose tried.
pub fn refined(scene: &Scene<'_>, start: Pose) -> Result<Pose, Cancelled> {
    let frame = start.view.frame;
    let pairs = neighbours(scene.mesh, &frame);
    let seen = |(moves, limbs): &(Vec<Move>, Vec<usize>)| {
        scene.watch.proceed(0.0)?;
        Ok::<_, Cancelled>(Tried { limbs: limbs.clone(), pose: Pose::seen(scene, frame, moves.clone()) })
    };
    let mut best = Pose::seen(scene, frame, start.moves);
    // None of the poses tried was better than the best of now.
    let mut known = BTreeSet::from([key(&best.moves)]);
    for pass in &PASSES {
        for _ in 0..ROUNDS {
            let steps = pass.steps(scene.mesh.limbs.len(), &pairs);
            let moved =
                steps.iter().map(|steps| (moved(&best.moves, steps), steps.iter().map(|step| step.0).collect()));
            let possible = moved.filter(|(moves, _)| moves.iter().all(|step| step.is_possible()));
            let new: Vec<(Vec<Move>, Vec<usize>)> = possible.filter(|(moves, _)| known.insert(key(moves))).collect();
            let tried = side_by_side(&new, seen).into_iter().collect::<Result<Vec<Tried>, Cancelled>>()?;
            let mut better: Vec<Tried> =
                tried.into_iter().filter(|tried| tried.pose.total() < best.total() - GAIN).collect();
            if better.is_empty() {
                break;
            }
            better.sort_by(|a, b| a.pose.total().total_cmp(&b.pose.total()));
            let (moves, limbs) = together(&best, &better);
            let another = limbs.len() > better[0].limbs.len() && known.insert(key(&moves));
            let together = if another { Some(seen(&(moves, limbs))?.pose) } else { None };
            let first = better.swap_remove(0).pose;
            best = match together {
                Some(together) if together.total() < first.total() => together,
                _ => first,
            };
        }
    }
    Ok(best)
}

/// All moves of different limbs at once, the better ones first, and the limbs they move.
fn together(best: &Pose, better: &[Tried]) -> (Vec<Move>, Vec<usize>) {
    let mut used = Vec::new();
    let mut moves = best.moves.clone();
    for tried in better {
        if tried.limbs.iter().all(|limb| !used.contains(limb)) {
            tried.limbs.iter().for_each(|&limb| moves[limb] = tried.pose.moves[limb]);
            used.extend(&tried.limbs);
        }
    }
    (moves, used)
}

/// The pose as it is, and those where limbs side by side in the picture exchange their moves: for every such pair alone
/// and for all of them together.
pub fn exchanges(mesh: &PreparedMesh, frame: &Frame, moves: &[Move]) -> Vec<Vec<Move>> {
    let exchanged = |pairs: &[[usize; 2]]| {
        let mut moves = moves.to_vec();
        pairs.iter().for_each(|&[i, j]| moves.swap(i, j));
        moves
    };
    let mut pairs = neighbours(mesh, frame);
    pairs.retain(|&[i, j]| moves[i] != moves[j]);
    let mut all = vec![moves.to_vec()];
    all.extend(pairs.iter().map(|&pair| exchanged(&[pair])));
    if pairs.len() > 1 {
        all.push(exchanged(&pairs));
    }
    all
}

/// A pose that was tried, and the limbs that were moved for it.
struct Tried {
    limbs: Vec<usize>,
    pose: Pose,
}

/// A pose as a key; a swing there and back leaves 0, never −0.
fn key(moves: &[Move]) -> Vec<[u64; 3]> {
    moves.iter().map(|step| [step.swing, step.bend, step.stretch].map(f64::to_bits)).collect()
}

fn moved(moves: &[Move], steps: &[(usize, Move)]) -> Vec<Move> {
    let mut moves = moves.to_vec();
    steps.iter().for_each(|&(limb, step)| moves[limb] = moves[limb].added(step));
    moves
}

impl Pass {
    /// Every limb swung, bent, longer and shorter by every step both ways, every pair of neighbours swung against each
    /// other.
    fn steps(&self, count: usize, pairs: &[[usize; 2]]) -> Vec<Vec<(usize, Move)>> {
        let swing = |degrees: f64| Move { swing: degrees.to_radians(), ..Move::default() };
        let bend = |degrees: f64| Move { bend: degrees.to_radians(), ..Move::default() };
        let stretch = |stretch: f64| Move { stretch, ..Move::default() };
        let swings: Vec<f64> = self.swings.iter().flat_map(|&a| [a, -a]).collect();
        let mut single: Vec<Move> = swings.iter().map(|&a| swing(a)).collect();
        single.extend([self.stretch, -self.stretch].map(stretch));
        if self.bend > 0.0 {
            single.extend([self.bend, -self.bend].map(bend));
        }
        let alone = (0..count).flat_map(|limb| single.iter().map(move |&step| vec![(limb, step)]));
        let against = pairs.iter().flat_map(|&[i, j]| swings.iter().map(move |&a| vec![(i, swing(a)), (j, swing(-a))]));
        alone.chain(against).collect()
    }
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
