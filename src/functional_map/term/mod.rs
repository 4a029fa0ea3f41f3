//! Quadratic terms beside the data: C is to commute with operators of both shapes.
//!
//! A file for each holds all there is to it: its operators, its parameters with their defaults and ranges, and its words in
//! the catalogue. A new one is such a file and a line in the list of [`terms`].

mod descriptors;
mod laplacian;
mod orientation;

use faer::Mat;
use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::openapi::RefOr;
use utoipa::openapi::schema::{OneOfBuilder, Schema};
use utoipa::{PartialSchema, ToSchema};

use super::parameter::{Declared, Parameter, number};
use super::problem::Commutator;
use super::regulariser::About;
use crate::mesh::TriangleMesh;
use crate::spectral::Spectrum;

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
    fn commutators(&self, shapes: [Shape<'_>; 2]) -> Vec<Commutator>;
}

impl Term {
    /// The operators of sketch and mesh that C is to commute with.
    pub fn commutators(&self, shapes: [Shape<'_>; 2]) -> Vec<Commutator> {
        self.commuting().commutators(shapes)
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

/// w, the parameter that all terms have.
const fn weight(default: f64) -> Declared<f64> {
    number("weight w of the term against the data term", default, 0.0, 1e9)
}

#[cfg(test)]
mod tests {
    use super::*;

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
