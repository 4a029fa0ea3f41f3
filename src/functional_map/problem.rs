//! The data term ‖C A − B‖²_F.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par, Scale, Side};

use super::MapError;
use crate::numerics::{DecompositionError, inner_product, least_squares};

/// The data term f(C) = ‖C A − B‖²_F of a functional map C (l × k), for A (k × q) and B (l × q).
///
/// Only the Gram matrices are kept, k² + k l numbers whatever q; constraints are added in blocks of columns.
#[derive(Clone, Debug)]
pub struct Problem {
    /// A Aᵀ, k × k.
    gram: Mat<f64>,
    /// B Aᵀ, l × k.
    cross: Mat<f64>,
    /// ‖B‖²_F.
    constant: f64,
    commutators: Vec<Commutator>,
    seen: Seen,
}

/// What of the bases themselves counts in some energies; nothing where it was not told.
#[derive(Clone, Debug)]
pub struct Seen {
    /// Of the sketch (k) and of the mesh (l), in units of the largest of both.
    pub eigenvalues: [Vec<f64>; 2],
    /// Rows of Φ (s × k) and of Ψ (t × l) at some vertices.
    pub samples: [Mat<f64>; 2],
}

/// A quadratic term w ‖C X − Y C‖²_F beside the data: C is to commute with operators of both shapes.
#[derive(Clone, Debug)]
pub struct Commutator {
    /// k × k.
    pub x: Mat<f64>,
    /// l × l.
    pub y: Mat<f64>,
    /// w, not negative.
    pub weight: f64,
}

impl Commutator {
    /// C X − Y C.
    fn failure(&self, c: MatRef<'_, f64>) -> Mat<f64> {
        c * &self.x - &self.y * c
    }

    /// The Lipschitz constant of the gradient at most: 2 w (σ_max(X) + σ_max(Y))², σ_max² bounded by the largest sums of
    /// rows and columns.
    fn lipschitz(&self) -> f64 {
        let bound = |m: &Mat<f64>| {
            let of_rows = m.row_iter().map(|row| row.iter().map(|x| x.abs()).sum::<f64>()).fold(0.0, f64::max);
            let of_columns = m.col_iter().map(|column| column.iter().map(|x| x.abs()).sum::<f64>()).fold(0.0, f64::max);
            (of_rows * of_columns).sqrt()
        };
        2.0 * self.weight * (bound(&self.x) + bound(&self.y)).powi(2)
    }
}

impl Problem {
    /// The problem without constraints for C with `rows` = l and `columns` = k.
    pub fn unconstrained(rows: usize, columns: usize) -> Self {
        Problem {
            gram: Mat::zeros(columns, columns),
            cross: Mat::zeros(rows, columns),
            constant: 0.0,
            commutators: Vec::new(),
            seen: Seen { eigenvalues: Default::default(), samples: [columns, rows].map(|n| Mat::zeros(0, n)) },
        }
    }

    /// The problem of A (k × q) and B (l × q).
    ///
    /// # Errors
    /// As [`Problem::constrain`].
    pub fn new(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Result<Self, MapError> {
        let mut problem = Problem::unconstrained(b.nrows(), a.nrows());
        problem.constrain(a, b)?;
        Ok(problem)
    }

    /// Adds a block of constraints C a = b, a k × p and b l × p.
    ///
    /// # Errors
    /// [`MapError`] if a shape does not fit or an entry is not finite; the problem is then as it was.
    pub fn constrain(&mut self, a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> Result<(), MapError> {
        check("A", a, (self.columns(), a.ncols()))?;
        check("B", b, (self.rows(), a.ncols()))?;
        matmul(&mut self.gram, Accum::Add, a, a.transpose(), 1.0, Par::Seq);
        matmul(&mut self.cross, Accum::Add, b, a.transpose(), 1.0, Par::Seq);
        self.constant += b.squared_norm_l2();
        Ok(())
    }

    /// Adds a term that C commutes with operators.
    ///
    /// # Errors
    /// [`MapError`] if a shape does not fit or an entry is not finite; the problem is then as it was.
    pub fn commute(&mut self, commutator: Commutator) -> Result<(), MapError> {
        check("X", commutator.x.as_ref(), (self.columns(), self.columns()))?;
        check("Y", commutator.y.as_ref(), (self.rows(), self.rows()))?;
        self.commutators.push(commutator);
        Ok(())
    }

    /// The same in the bases Φ P and Ψ Q, P (k × k) and Q (l × l) orthogonal: C there is Qᵀ C P.
    pub fn turned(&self, p: MatRef<'_, f64>, q: MatRef<'_, f64>) -> Problem {
        let commutators = self.commutators.iter().map(|Commutator { x, y, weight }| Commutator {
            x: p.transpose() * x * p,
            y: q.transpose() * y * q,
            weight: *weight,
        });
        let [phi, psi] = &self.seen.samples;
        let along = |eigenvalues: &[f64], x: MatRef<'_, f64>| {
            let of = |i: usize| x.col(i).iter().zip(eigenvalues).map(|(x, l)| l * x * x).sum();
            (0..x.ncols()).map(of).collect()
        };
        let [sketch, mesh] = &self.seen.eigenvalues;
        Problem {
            gram: p.transpose() * &self.gram * p,
            cross: q.transpose() * &self.cross * p,
            constant: self.constant,
            commutators: commutators.collect(),
            seen: Seen { eigenvalues: [along(sketch, p), along(mesh, q)], samples: [phi * p, psi * q] },
        }
    }

    /// Tells of the bases.
    pub fn see(&mut self, seen: Seen) {
        self.seen = seen;
    }

    /// What was told of the bases.
    pub fn seen(&self) -> &Seen {
        &self.seen
    }

    /// Whether the rows of C are independent of each other: nothing but the data counts.
    pub fn is_of_rows(&self) -> bool {
        self.commutators.iter().all(|commutator| commutator.weight == 0.0)
    }

    /// l, the rows of C.
    pub fn rows(&self) -> usize {
        self.cross.nrows()
    }

    /// k, the columns of C.
    pub fn columns(&self) -> usize {
        self.cross.ncols()
    }

    /// A Aᵀ, k × k.
    pub fn gram(&self) -> MatRef<'_, f64> {
        self.gram.as_ref()
    }

    /// B Aᵀ, l × k.
    pub fn cross(&self) -> MatRef<'_, f64> {
        self.cross.as_ref()
    }

    /// ‖B‖²_F, the part of the data term that does not depend on C.
    pub fn constant(&self) -> f64 {
        self.constant
    }

    /// ‖C A − B‖²_F and what is added to it, never negative; exact to rounding of ‖B‖²_F and ‖C A‖²_F.
    pub fn value(&self, c: MatRef<'_, f64>) -> f64 {
        (self.constant + self.variable(c)).max(0.0)
    }

    /// ‖C A − B‖²_F − ‖B‖²_F = ⟨C A Aᵀ − 2 B Aᵀ, C⟩ and what is added to it: what solvers compare, free of the rounding of a
    /// large ‖B‖.
    pub fn variable(&self, c: MatRef<'_, f64>) -> f64 {
        let data = inner_product((c * &self.gram - Scale(2.0) * &self.cross).as_ref(), c);
        let added = self.commutators.iter().map(|term| term.weight * term.failure(c).squared_norm_l2());
        data + added.sum::<f64>()
    }

    /// 2 C A Aᵀ − 2 B Aᵀ, l × k, eq. 3.30, and of every commutator 2 w (D Xᵀ − Yᵀ D), D = C X − Y C.
    pub fn gradient(&self, c: MatRef<'_, f64>) -> Mat<f64> {
        let data = Scale(2.0) * (c * &self.gram - &self.cross);
        self.commutators.iter().fold(data, |gradient, Commutator { x, y, weight }| {
            let failure = c * x - y * c;
            gradient + Scale(2.0 * weight) * (&failure * x.transpose() - y.transpose() * &failure)
        })
    }

    /// L = 2 σ_max(A Aᵀ), the Lipschitz constant of the gradient; with commutators a bound of it.
    ///
    /// # Errors
    /// [`MapError::Decomposition`] if the eigenvalues of A Aᵀ do not converge.
    pub fn lipschitz(&self) -> Result<f64, MapError> {
        let eigenvalues = self.gram.self_adjoint_eigenvalues(Side::Lower);
        let eigenvalues = eigenvalues.map_err(|_| DecompositionError::Eigenvalues { size: self.columns() })?;
        let added: f64 = self.commutators.iter().map(Commutator::lipschitz).sum();
        Ok(2.0 * eigenvalues.into_iter().fold(0.0, f64::max) + added)
    }
}

/// C⁰ of eq. 2.13 (l × k): the C of least norm among the minimisers of the data term.
///
/// # Errors
/// [`MapError::Decomposition`] if the eigenvalues of A Aᵀ do not converge.
pub fn least_squares(problem: &Problem) -> Result<Mat<f64>, MapError> {
    Ok(least_squares::minimum_norm(problem.gram(), problem.cross())?)
}

/// Whether a matrix has the wanted number of rows and columns, and finite entries only.
pub(super) fn check(matrix: &'static str, entries: MatRef<'_, f64>, wanted: (usize, usize)) -> Result<(), MapError> {
    let found = entries.shape();
    if found != wanted {
        return Err(MapError::Shape { matrix, found, wanted });
    }
    for (column, values) in entries.col_iter().enumerate() {
        if let Some(row) = values.iter().position(|value| !value.is_finite()) {
            return Err(MapError::NotFinite { matrix, row, column });
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::random;

    fn example() -> (Mat<f64>, Mat<f64>, Mat<f64>, Problem) {
        let (a, b) = (random::normal(4, 30, 1), random::normal(6, 30, 2));
        let problem = Problem::new(a.as_ref(), b.as_ref()).unwrap();
        (a, b, random::normal(6, 4, 3), problem)
    }

    #[test]
    fn the_value_is_that_of_the_matrices() {
        let (a, b, c, problem) = example();
        let direct = (&c * a - b).squared_norm_l2();
        assert!((problem.value(c.as_ref()) - direct).abs() < 1e-12 * direct);
    }

    #[test]
    fn the_value_of_an_exact_map_is_zero_and_not_negative() {
        for seed in 0..20 {
            let (a, c) = (random::ill_conditioned(5, 50, 1e4, seed), random::normal(7, 5, seed + 100));
            let problem = Problem::new(a.as_ref(), (&c * &a).as_ref()).unwrap();
            let value = problem.value(c.as_ref());
            assert!((0.0..1e-13 * problem.constant()).contains(&value), "{value}");
        }
    }

    #[test]
    fn the_gradient_is_the_slope_of_the_value() {
        let (_, _, c, problem) = example();
        let (direction, step) = (random::normal(6, 4, 4), 1e-5);
        let difference =
            problem.value((&c + step * &direction).as_ref()) - problem.value((&c - step * &direction).as_ref());
        let slope = inner_product(problem.gradient(c.as_ref()).as_ref(), direction.as_ref());
        assert!((difference / (2.0 * step) - slope).abs() < 1e-5 * slope.abs());
    }

    #[test]
    fn commutators_count_in_value_and_gradient() {
        let (_, _, c, mut problem) = example();
        let (x, y) = (random::normal(4, 4, 8), random::normal(6, 6, 9));
        let before = problem.value(c.as_ref());
        problem.commute(Commutator { x: x.clone(), y: y.clone(), weight: 0.7 }).unwrap();
        let added = 0.7 * (&c * &x - &y * &c).squared_norm_l2();
        assert!((problem.value(c.as_ref()) - before - added).abs() < 1e-10 * added);
        let (direction, step) = (random::normal(6, 4, 4), 1e-5);
        let difference =
            problem.value((&c + step * &direction).as_ref()) - problem.value((&c - step * &direction).as_ref());
        let slope = inner_product(problem.gradient(c.as_ref()).as_ref(), direction.as_ref());
        assert!((difference / (2.0 * step) - slope).abs() < 1e-5 * slope.abs());
        let change = problem.gradient((&c + &direction).as_ref()) - problem.gradient(c.as_ref());
        assert!(change.norm_l2() <= problem.lipschitz().unwrap() * direction.norm_l2());
        assert!(problem.commute(Commutator { x: y, y: x, weight: 1.0 }).is_err());
    }

    #[test]
    fn in_turned_bases_the_value_is_the_same() {
        let (_, _, c, mut problem) = example();
        problem.commute(Commutator { x: random::normal(4, 4, 8), y: random::normal(6, 6, 9), weight: 0.7 }).unwrap();
        let turn = |n: usize, seed: u64| random::normal(n, n, seed).qr().compute_Q();
        let (p, q) = (turn(4, 10), turn(6, 11));
        let value = problem.value(c.as_ref());
        let turned = problem.turned(p.as_ref(), q.as_ref()).value((q.transpose() * c * p).as_ref());
        assert!((value - turned).abs() < 1e-10 * value);
    }

    #[test]
    fn the_lipschitz_constant_is_reached_and_not_exceeded() {
        let (a, _, _, problem) = example();
        let lipschitz = problem.lipschitz().unwrap();
        let largest = a.singular_values().unwrap()[0];
        assert!((lipschitz - 2.0 * largest * largest).abs() < 1e-10 * lipschitz);
    }

    #[test]
    fn blocks_of_constraints_add_up() {
        let (a, b, c, problem) = example();
        let mut blockwise = Problem::unconstrained(6, 4);
        for start in [0, 10, 20] {
            blockwise.constrain(a.subcols(start, 10), b.subcols(start, 10)).unwrap();
        }
        let value = problem.value(c.as_ref());
        assert!((blockwise.value(c.as_ref()) - value).abs() < 1e-12 * value);
    }

    #[test]
    fn least_squares_has_no_gradient() {
        let problem = example().3;
        let c = least_squares(&problem).unwrap();
        assert!(problem.gradient(c.as_ref()).norm_max() < 1e-10);
    }

    #[test]
    fn matrices_that_do_not_fit_are_named() {
        let (a, mut b) = (random::normal(4, 30, 1), random::normal(6, 29, 2));
        let error = Problem::new(a.as_ref(), b.as_ref()).unwrap_err();
        assert_eq!(error, MapError::Shape { matrix: "B", found: (6, 29), wanted: (6, 30) });
        b = random::normal(6, 30, 2);
        b[(5, 7)] = f64::NAN;
        let error = Problem::new(a.as_ref(), b.as_ref()).unwrap_err();
        assert_eq!(error, MapError::NotFinite { matrix: "B", row: 5, column: 7 });
    }
}
