//! C and the order of the regions together, eq. 2.14 [PBB+13].

use faer::Mat;
use pathfinding::{kuhn_munkres::kuhn_munkres_min, matrix::Matrix};

use super::MapError;
use super::diagonal::Diagonal;
use super::problem::{Problem, least_squares};
use super::regulariser::{PermutedL1, Regulariser};
use super::solve::{Solution, solve};
use crate::numerics::Watch;

/// The cost of an assignment counts in steps of this share of the largest.
const STEPS: f64 = 1e12;

/// The functions of regions whose order is not known, and a problem of what is known without it.
pub struct Unordered {
    /// Of landmarks, points and terms.
    pub known: Problem,
    /// For every region of the sketch its functions, k × p.
    pub sketch: Vec<Mat<f64>>,
    /// For every region of the mesh its functions, l × p.
    pub mesh: Vec<Mat<f64>>,
}

/// A pair of regions: of the sketch and of the mesh.
pub type Pair = [usize; 2];

/// A functional map and the order of the regions that goes with it.
pub struct Ordered {
    pub pairs: Vec<Pair>,
    /// C⁰ of the order that was begun with, of which W is made.
    pub start: Mat<f64>,
    pub weights: Mat<f64>,
    /// Its report is that of all turns: each begins where the one before ended, with another order.
    pub solution: Solution,
}

impl Unordered {
    /// The data term with the regions in this order.
    ///
    /// # Errors
    /// [`MapError`] if a shape does not fit or an entry is not finite.
    pub fn problem(&self, pairs: &[Pair]) -> Result<Problem, MapError> {
        let mut problem = self.known.clone();
        for &[r, s] in pairs {
            problem.constrain(self.sketch[r].as_ref(), self.mesh[s].as_ref())?;
        }
        Ok(problem)
    }

    /// The pairs of least Σ ‖C A_r − B_s‖²_F: as many as the shape of fewer regions has, in the order of the sketch's.
    fn assignment(&self, c: &Mat<f64>) -> Vec<Pair> {
        let cost = |a: &Mat<f64>| {
            let image = c * a;
            self.mesh.iter().map(|b| (&image - b).squared_norm_l2()).collect::<Vec<f64>>()
        };
        let costs: Vec<Vec<f64>> = self.sketch.iter().map(cost).collect();
        if costs.is_empty() || self.mesh.is_empty() {
            return Vec::new();
        }
        let largest = costs.iter().flatten().copied().fold(f64::MIN_POSITIVE, f64::max);
        let (x, y) = (self.sketch.len(), self.mesh.len());
        let whole = |r: usize, s: usize| (costs[r][s] / largest * STEPS) as i64;
        if x <= y {
            let (_, of_sketch) = kuhn_munkres_min(&Matrix::from_fn(x, y, |(r, s)| whole(r, s)));
            of_sketch.into_iter().enumerate().map(|(r, s)| [r, s]).collect()
        } else {
            let (_, of_mesh) = kuhn_munkres_min(&Matrix::from_fn(y, x, |(s, r)| whole(r, s)));
            let mut pairs: Vec<Pair> = of_mesh.into_iter().enumerate().map(|(s, r)| [r, s]).collect();
            pairs.sort_unstable();
            pairs
        }
    }

    /// The pairs that the plain diagonal as C assigns.
    fn of_diagonal(&self) -> Vec<Pair> {
        let (rows, columns) = (self.known.rows(), self.known.columns());
        let line = Diagonal::plain(rows, columns);
        self.assignment(&Mat::from_fn(rows, columns, |i, j| if line.distance(i, j) < 0.5 { 1.0 } else { 0.0 }))
    }
}

/// The minimiser of ‖C A − B Π‖²_F + γ ‖W ⊙ C‖₁ in C and Π: in turns until the order stays, from `pairs` and from those of the
/// plain diagonal; of both the one of less energy. `weights` makes W of C⁰.
///
/// Each turn minimises in one of both and lowers the energy; that the least of all is reached is not known.
///
/// # Errors
/// As [`solve`].
pub fn ordered(
    unordered: &Unordered,
    term: &PermutedL1,
    pairs: Vec<Pair>,
    weights: &dyn Fn(&Mat<f64>) -> Mat<f64>,
    watch: &dyn Watch,
) -> Result<Ordered, MapError> {
    let first = from(unordered, term, pairs, weights, watch)?;
    let second = from(unordered, term, unordered.of_diagonal(), weights, watch)?;
    let objective = |ordered: &Ordered| ordered.solution.report.objective();
    Ok(if objective(&second) < objective(&first) { second } else { first })
}

fn from(
    unordered: &Unordered,
    term: &PermutedL1,
    mut pairs: Vec<Pair>,
    weights: &dyn Fn(&Mat<f64>) -> Mat<f64>,
    watch: &dyn Watch,
) -> Result<Ordered, MapError> {
    let regulariser = Regulariser::PermutedL1(*term);
    let problem = unordered.problem(&pairs)?;
    let start = least_squares(&problem)?;
    let w = weights(&start);
    let mut solution = solve(&problem, &regulariser, &w, start.clone(), watch)?;
    for _ in 1..term.rounds {
        let better = unordered.assignment(&solution.c);
        if better == pairs {
            break;
        }
        pairs = better;
        let next = solve(&unordered.problem(&pairs)?, &regulariser, &w, solution.c, watch)?;
        let gains = next.report.objective() < solution.report.objective();
        solution = Solution { c: next.c, report: solution.report.followed_by(next.report) };
        if !gains {
            break;
        }
    }
    Ok(Ordered { pairs, start, weights: w, solution })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::{Report, Unwatched, random};

    /// Regions of a shape matched to itself, those of the mesh in another order: region r is number 3 r + 1 mod 7 there.
    fn shuffled(noise: f64) -> (Unordered, Vec<Pair>) {
        let (k, p) = (10, 6);
        let sketch: Vec<Mat<f64>> = (0..7).map(|r| random::normal(k, p, r)).collect();
        let to = |r: usize| (3 * r + 1) % 7;
        let mut mesh = vec![Mat::zeros(k, p); 7];
        for (r, of_sketch) in sketch.iter().enumerate() {
            mesh[to(r)] = of_sketch + noise * random::normal(k, p, 100 + r as u64);
        }
        let pairs = (0..7).map(|r| [r, to(r)]).collect();
        (Unordered { known: Problem::unconstrained(k, k), sketch, mesh }, pairs)
    }

    fn slanted(c: &Mat<f64>) -> Mat<f64> {
        Mat::from_fn(c.nrows(), c.ncols(), |i, j| (i as f64 - j as f64).abs())
    }

    #[test]
    fn a_known_permutation_is_recovered_from_a_wrong_one() {
        for noise in [0.0, 0.2] {
            let (unordered, right) = shuffled(noise);
            let wrong: Vec<Pair> = (0..7).map(|r| [r, (r + 2) % 7]).collect();
            let found = ordered(&unordered, &PermutedL1::default(), wrong, &slanted, &Unwatched).unwrap();
            assert_eq!(found.pairs, right);
            let away = (found.solution.c - Mat::<f64>::identity(10, 10)).norm_max();
            assert!(away < 0.02 + noise, "{away}");
        }
    }

    #[test]
    fn all_turns_are_told_from_the_first_start_on() {
        let (unordered, right) = shuffled(0.2);
        let wrong: Vec<Pair> = (0..7).map(|r| [r, (r + 2) % 7]).collect();
        let begun = unordered.problem(&wrong).unwrap();
        let found = from(&unordered, &PermutedL1::default(), wrong, &slanted, &Unwatched).unwrap();
        let Report { iterations, history, .. } = found.solution.report;
        assert_eq!(found.start, least_squares(&begun).unwrap());
        let energy = |problem: &Problem, c: &Mat<f64>| {
            let w = slanted(c);
            let weighted = w.col_iter().zip(c.col_iter()).flat_map(|(w, c)| w.iter().zip(c.iter()));
            problem.value(c.as_ref()) + weighted.map(|(w, c)| w * c.abs()).sum::<f64>()
        };
        assert!((history[0] - energy(&begun, &found.start)).abs() < 1e-9 * history[0]);
        let ended = energy(&unordered.problem(&right).unwrap(), &found.solution.c);
        assert!((history[iterations] - ended).abs() < 1e-9 * history[0]);
        assert!(iterations >= 400 && history.len() == iterations + 1, "{iterations}");
        assert!(history.is_sorted_by(|before, after| after <= before));
    }

    #[test]
    fn the_right_order_stays_and_is_l1() {
        let (unordered, right) = shuffled(0.1);
        let found = ordered(&unordered, &PermutedL1::default(), right.clone(), &slanted, &Unwatched).unwrap();
        let problem = unordered.problem(&right).unwrap();
        let l1: Regulariser = serde_json::from_str(r#"{"type": "l1"}"#).unwrap();
        let start = least_squares(&problem).unwrap();
        let wanted = solve(&problem, &l1, &slanted(&start), start, &Unwatched).unwrap();
        assert_eq!(found.pairs, right);
        assert!((found.solution.c - wanted.c).norm_max() < 1e-9);
    }

    #[test]
    fn a_shape_of_more_regions_has_some_left_over() {
        let (mut unordered, right) = shuffled(0.0);
        unordered.mesh.truncate(5);
        let pairs = unordered.assignment(&Mat::identity(10, 10));
        assert_eq!(pairs, right.into_iter().filter(|pair| pair[1] < 5).collect::<Vec<_>>());
        unordered.sketch.clear();
        assert!(unordered.assignment(&Mat::identity(10, 10)).is_empty());
    }
}
