/// When an iteration over matrices ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stopping {
    pub max_iterations: usize,
    /// Largest fixed-point residual, as a share of max(1, ‖X‖_F), that counts as converged; 0 = none does, so that all
    /// iterations are carried out.
    pub tolerance: f64,
}

impl Stopping {
    /// Whether a `residual` at an iterate of Frobenius norm `norm` counts as converged.
    pub(super) fn reached(&self, residual: f64, norm: f64) -> bool {
        self.tolerance > 0.0 && residual <= self.tolerance * norm.max(1.0)
    }
}
