//! A search for the minimiser of data term and regulariser.

use faer::{Mat, MatRef};

use crate::functional_map::MapError;
use crate::functional_map::problem::Problem;
use crate::numerics::proximal_gradient::{self, Composite};
use crate::numerics::{Report, Stopped, Stopping, Watch};

/// What C (l × k) is searched for in, and from where.
pub struct Search<'a> {
    pub problem: &'a Problem,
    /// W, l × k.
    pub weights: &'a Mat<f64>,
    /// C⁰, l × k.
    pub start: Mat<f64>,
    pub watch: &'a dyn Watch,
}

/// The minimiser C and how it was found. The objectives in the report are without the constant ‖B‖²_F.
pub type Found = Result<(Mat<f64>, Report), MapError>;

impl Search<'_> {
    /// The minimiser of ‖C A − B‖²_F + g(C) by the fast gradient method: g by its value and by V ↦ the minimiser X of
    /// λ g(X) + ½ ‖X − V‖²_F beside g(X), λ being `step`.
    pub fn by_proximal_gradients(
        self,
        term: impl Fn(MatRef<'_, f64>) -> Result<f64, MapError>,
        proximal: impl Fn(MatRef<'_, f64>) -> Result<(Mat<f64>, f64), MapError>,
        step: f64,
        stopping: Stopping,
    ) -> Found {
        let Search { problem, start, watch, .. } = self;
        let h = Composite {
            smooth: |c: MatRef<'_, f64>| problem.variable(c),
            term,
            gradient: |c: MatRef<'_, f64>| problem.gradient(c),
            proximal,
            step,
        };
        proximal_gradient::minimise(&h, start, stopping, watch)
    }

    /// A minimiser that was found without iterating, reported by its objective beside that of the start.
    pub fn directly(&self, c: Mat<f64>, objective: impl Fn(MatRef<'_, f64>) -> f64) -> (Mat<f64>, Report) {
        let history = vec![objective(self.start.as_ref()), objective(c.as_ref())];
        (c, Report { iterations: 0, history, stopped: Stopped::Converged })
    }
}
