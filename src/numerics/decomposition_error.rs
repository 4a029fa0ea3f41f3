/// A dense decomposition did not converge, which finite input hardly ever provokes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DecompositionError {
    #[error("the singular values of a {rows} × {columns} matrix did not converge")]
    SingularValues { rows: usize, columns: usize },
    #[error("the eigenvalues of a {size} × {size} matrix did not converge")]
    Eigenvalues { size: usize },
}
