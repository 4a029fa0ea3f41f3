//! The weights W (l × k), small where C is expected to be large.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// How W is made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "method", rename_all = "snake_case", deny_unknown_fields)]
pub enum Weights {
    /// Distance from the line through the `sparsity` · k largest entries of C⁰, to a `power` (§3.2.5).
    Cosamp {
        #[serde(default = "sparsity")]
        sparsity: f64,
        #[serde(default = "power")]
        power: f64,
    },
    /// Distance from the diagonal whose slope the two spectra tell (Rodolà et al. 2017).
    Slant {},
    /// The resolvent mask (Ren et al. 2019).
    Resolvent {},
    /// All ones.
    None {},
}

fn sparsity() -> f64 {
    0.8
}

fn power() -> f64 {
    1.2
}
