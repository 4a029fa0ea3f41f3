//! Matrices of four rows and columns, which place things in space.

/// By columns.
pub(super) type Matrix = [[f64; 4]; 4];

/// What leaves all as it is placed.
pub(super) const IDENTITY: Matrix = [[1., 0., 0., 0.], [0., 1., 0., 0.], [0., 0., 1., 0.], [0., 0., 0., 1.]];

/// The matrix that places as b does and then as a does.
pub(super) fn product(a: Matrix, b: Matrix) -> Matrix {
    b.map(|column| [0, 1, 2, 3].map(|i: usize| (0..4).map(|j| a[j][i] * column[j]).sum()))
}

/// Where a matrix places a point. Negative zero becomes zero, so that equal points have equal bits.
pub(super) fn placed(m: &Matrix, p: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i: usize| m[0][i] * p[0] + m[1][i] * p[1] + m[2][i] * p[2] + m[3][i] + 0.0)
}

/// Of the upper left 3 × 3.
pub(super) fn determinant([a, b, c, _]: &Matrix) -> f64 {
    a[0] * (b[1] * c[2] - b[2] * c[1]) - b[0] * (a[1] * c[2] - a[2] * c[1]) + c[0] * (a[1] * b[2] - a[2] * b[1])
}
