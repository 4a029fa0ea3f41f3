//! Quadratic terms beside the data: C is to commute with operators of both shapes.
//!
//! A file for each holds all there is to it: its operators, its parameters with their defaults and ranges, and its words in
//! the catalogue. A new one is such a file and a line in the list of [`terms`].

mod descriptors;
mod laplacian;
mod orientation;

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::openapi::RefOr;
use utoipa::openapi::schema::{OneOfBuilder, Schema};
use utoipa::{PartialSchema, ToSchema};

use super::parameter::{Declared, Parameter, number};
use super::problem::Commutator;
use super::regulariser::About;
use crate::mesh::TriangleMesh;
use crate::numerics::{Cancelled, Watch};
use crate::spectral::Spectrum;

/// Vertices between two questions to the watcher.
const ROUND: usize = 1024;

/// What the operators of a term are made of.
#[derive(Clone, Copy)]
pub struct Shape<'a> {
    pub mesh: &'a TriangleMesh,
    /// At area 1.
    pub spectrum: &'a Spectrum,
    /// The eigenvalues as descriptors see them.
    pub eigenvalues: &'a [f64],
    /// Functions that correspond on both shapes, n × q, one after the other; of either shape as many.
    pub functions: &'a Mat<f64>,
}

/// Makes what all terms are of their list: the variant, whose name in snake case is the `type` in a request, the file and the
/// type in it.
macro_rules! terms {
    ($($variant:ident = $file:ident::$term:ident,)+) => {
        $(pub use $file::$term;)+

        /// A quadratic term w Σ ‖C X − Y C‖²_F of the energy.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[serde(tag = "type", rename_all = "snake_case")]
        pub enum Term {
            $($variant($term),)+
        }

        /// Every term a request can name.
        pub const ALL: &[&About] = &[$(&$file::ABOUT,)+];

        impl Term {
            fn commuting(&self) -> &dyn Commuting {
                match self {
                    $(Term::$variant(term) => term,)+
                }
            }
        }
    };
}

terms! {
    Laplacian = laplacian::Laplacian,
    Descriptors = descriptors::Descriptors,
    Orientation = orientation::Orientation,
}

/// A term with the values of its parameters.
trait Commuting {
    fn about(&self) -> &'static About;

    /// The operators of sketch and mesh that C is to commute with.
    fn commutators(&self, shapes: [Shape<'_>; 2], watch: &dyn Watch) -> Result<Vec<Commutator>, Cancelled>;
}

impl Term {
    /// The operators of sketch and mesh that C is to commute with.
    ///
    /// # Errors
    /// [`Cancelled`] by the watcher, asked every so many vertices of every function.
    pub fn commutators(&self, shapes: [Shape<'_>; 2], watch: &dyn Watch) -> Result<Vec<Commutator>, Cancelled> {
        self.commuting().commutators(shapes, watch)
    }

    /// What is wrong with the parameters: the name of each field at fault, and why.
    pub fn faults(&self) -> Vec<(&'static str, String)> {
        let values = serde_json::to_value(self).unwrap_or_default();
        // What is not a number has no value in JSON.
        let value = |parameter: &Parameter| values.get(parameter.name).and_then(Value::as_f64).unwrap_or(f64::NAN);
        let parameters = self.commuting().about().parameters.iter();
        parameters.filter_map(|parameter| Some((parameter.name, parameter.fault(value(parameter))?))).collect()
    }
}

impl PartialSchema for Term {
    fn schema() -> RefOr<Schema> {
        let variants = ALL.iter().fold(OneOfBuilder::new(), |variants, about| variants.item(about.schema()));
        variants.description(Some("A quadratic term w Σ ‖C X − Y C‖²_F of the energy.")).into()
    }
}

impl ToSchema for Term {}

/// Φᵀ X (k × k), X being n × k with these entries: in rounds of vertices, between which the watcher is asked.
fn projected(
    phi: MatRef<'_, f64>,
    entry: impl Fn(usize, usize) -> f64,
    watch: &dyn Watch,
) -> Result<Mat<f64>, Cancelled> {
    let (n, k) = phi.shape();
    let mut projected = Mat::zeros(k, k);
    for first in (0..n).step_by(ROUND) {
        watch.proceed(0.0)?;
        let rows = phi.subrows(first, ROUND.min(n - first));
        let block = Mat::from_fn(rows.nrows(), k, |x, i| entry(first + x, i));
        matmul(&mut projected, Accum::Add, rows.transpose(), &block, 1.0, Par::Seq);
    }
    Ok(projected)
}

/// w, the parameter that all terms have.
const fn weight(default: f64) -> Declared<f64> {
    number("weight w of the term against the data term", default, 0.0, 1e9)
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;
    use crate::mesh::solids::sheet;
    use crate::spectral::{Boundary, spectrum};

    /// Cancels at the question with this number.
    struct CancelsAt(usize, AtomicUsize);

    impl Watch for CancelsAt {
        fn proceed(&self, _fraction: f64) -> Result<(), Cancelled> {
            if self.1.fetch_add(1, Ordering::Relaxed) == self.0 { Err(Cancelled) } else { Ok(()) }
        }
    }

    #[test]
    fn between_functions_and_between_rounds_of_vertices_a_term_can_be_stopped() {
        let mesh = sheet(40, 30);
        let spectrum = spectrum(&mesh, 3, Boundary::Neumann, &crate::numerics::Unwatched).unwrap().at_unit_area(3);
        let functions = Mat::from_fn(mesh.positions().len(), 2, |x, f| ((x * (f + 1)) as f64).sin());
        let shape =
            Shape { mesh: &mesh, spectrum: &spectrum, eigenvalues: &spectrum.eigenvalues, functions: &functions };
        for term in [Term::Descriptors(Descriptors { weight: 1.0 }), Term::Orientation(Orientation { weight: 1.0 })] {
            // Two rounds of vertices of two functions on two shapes.
            for question in 0..8 {
                let watch = CancelsAt(question, AtomicUsize::new(0));
                assert_eq!(term.commutators([shape; 2], &watch).unwrap_err(), Cancelled);
            }
        }
    }

    #[test]
    fn a_term_is_read_with_the_defaults_it_is_described_with() {
        for about in ALL {
            let term: Term = serde_json::from_str(&format!(r#"{{"type": "{}"}}"#, about.r#type)).unwrap();
            assert_eq!((term.commuting().about().r#type, term.faults()), (about.r#type, vec![]));
            let written = serde_json::to_value(&term).unwrap();
            assert_eq!(written.as_object().unwrap().len(), 1 + about.parameters.len());
        }
        assert!(serde_json::from_str::<Term>(r#"{"type": "laplacian", "wait": 1}"#).is_err());
        let wrong = Term::Laplacian(Laplacian { weight: -1.0 });
        assert_eq!(wrong.faults()[0].0, "weight");
    }
}
