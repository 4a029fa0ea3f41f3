use faer::MatRef;

/// Σ aᵢⱼ bᵢⱼ of two matrices of one shape.
pub fn inner_product(a: MatRef<'_, f64>, b: MatRef<'_, f64>) -> f64 {
    a.col_iter().zip(b.col_iter()).map(|(a, b)| a.transpose() * b).sum()
}
