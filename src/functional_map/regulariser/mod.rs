//! What is added to the data term ‖C A − B‖²_F.
//!
//! A file for each regulariser holds all there is to it: ρ, its gradient or proximal operator and the minimiser, the
//! parameters with their defaults and ranges, and its words in the catalogue. A new one is such a file and a line in the
//! list of [`regularisers`].

mod l1;
mod l2;
mod least_squares;
mod matrix_completion;
mod nuclear;
mod part_indicator;
mod permuted_l1;
mod search;

use faer::{Mat, MatRef};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use utoipa::openapi::RefOr;
use utoipa::openapi::schema::{AdditionalProperties, ObjectBuilder, OneOfBuilder, Schema, Type};
use utoipa::{PartialSchema, ToSchema};

use super::parameter::{Declared, Parameter, integer, number};

pub use l2::L2Solver;
pub(super) use search::{Found, Search};

/// Makes what all regularisers are of their list: the variant, whose name in snake case is the `type` in a request, the
/// file and the type in it.
macro_rules! regularisers {
    ($($variant:ident = $file:ident::$term:ident,)+) => {
        $(pub use $file::$term;)+

        /// The regularisation term γ ρ(C) of the problem and how it is solved.
        #[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
        #[serde(tag = "type", rename_all = "snake_case")]
        pub enum Regulariser {
            $($variant($term),)+
        }

        /// Every regulariser a request can name, in the order of the thesis.
        pub const ALL: &[&About] = &[$(&$file::ABOUT,)+];

        impl Regulariser {
            fn about(&self) -> &'static About {
                match self {
                    $(Regulariser::$variant(_) => &$file::ABOUT,)+
                }
            }

            /// As [`Term::minimiser`].
            pub(super) fn minimiser(&self, search: Search<'_>) -> Found {
                match self {
                    $(Regulariser::$variant(term) => term.minimiser(search),)+
                }
            }
        }
    };
}

regularisers! {
    None = least_squares::LeastSquares,
    L2 = l2::L2,
    L1 = l1::L1,
    Nuclear = nuclear::Nuclear,
    PermutedL1 = permuted_l1::PermutedL1,
    MatrixCompletion = matrix_completion::MatrixCompletion,
    PartIndicator = part_indicator::PartIndicator,
}

impl Regulariser {
    /// The `type` in a request.
    pub fn name(&self) -> &'static str {
        self.about().r#type
    }

    /// What is wrong with the parameters: the name of each field at fault, and why.
    pub fn faults(&self) -> Vec<(&'static str, String)> {
        let values = serde_json::to_value(self).unwrap_or_default();
        // What is not a number has no value in JSON.
        let value = |parameter: &Parameter| values.get(parameter.name).and_then(Value::as_f64).unwrap_or(f64::NAN);
        let parameters = self.about().parameters.iter();
        parameters.filter_map(|parameter| Some((parameter.name, parameter.fault(value(parameter))?))).collect()
    }
}

/// A regularisation term γ ρ(C) with the values of its parameters.
trait Term {
    /// The C (l × k) that minimises ‖C A − B‖²_F + γ ρ(C), and how it was found.
    fn minimiser(&self, search: Search<'_>) -> Found;
}

/// A regulariser in words, and what its parameters may be.
#[derive(Debug)]
pub struct About {
    /// The `type` in a request: the variant of [`Regulariser`] in snake case.
    pub r#type: &'static str,
    pub title: &'static str,
    /// What C minimises.
    pub formula: Formula,
    /// Number of the equation in the thesis.
    pub equation: &'static str,
    pub solver: &'static str,
    /// Without `type`.
    pub parameters: &'static [Parameter],
}

impl About {
    /// The schema of the `regulariser` in a request.
    pub(in crate::functional_map) fn schema(&self) -> ObjectBuilder {
        let tag = ObjectBuilder::new().schema_type(Type::String).enum_values(Some([self.r#type]));
        let object = ObjectBuilder::new().description(Some(self.title)).property("type", tag).required("type");
        let parameters = self.parameters.iter();
        let object = parameters.fold(object, |object, parameter| object.property(parameter.name, parameter.schema()));
        object.additional_properties(Some(AdditionalProperties::FreeForm(false)))
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct Formula {
    pub text: &'static str,
    pub latex: &'static str,
}

impl PartialSchema for Regulariser {
    fn schema() -> RefOr<Schema> {
        let variants = ALL.iter().fold(OneOfBuilder::new(), |variants, about| variants.item(about.schema()));
        let about = "The regularisation term γ ρ(C) of the problem and how it is solved.";
        variants.description(Some(about)).into()
    }
}

impl ToSchema for Regulariser {}

/// γ, the parameter that all terms have.
const fn gamma(default: f64) -> Declared<f64> {
    number("weight γ of the regularisation against the data term", default, 0.0, 1e9)
}

/// A type of the parameters of a term whose minimiser iterates: γ with the default given, `max_iterations` and `tolerance`,
/// which all of them have, and after these its own, each with what is declared of it.
macro_rules! iterated {
    ($(#[$about:meta])* pub struct $name:ident { gamma = $gamma:expr; $($field:ident: $type:ty = $declared:expr,)* }) => {
        $crate::functional_map::parameter::parameters! {
            $(#[$about])*
            pub struct $name {
                gamma: f64 = super::gamma($gamma),
                max_iterations: usize = super::MAX_ITERATIONS,
                tolerance: f64 = super::TOLERANCE,
                $($field: $type = $declared,)*
            }
        }

        impl $name {
            fn stopping(&self) -> $crate::numerics::Stopping {
                $crate::numerics::Stopping { max_iterations: self.max_iterations, tolerance: self.tolerance }
            }
        }
    };
}

use iterated;

const MAX_ITERATIONS: Declared<usize> = integer("iterations after which an iterative solver stops", 200, 1, 20_000);

const TOLERANCE: Declared<f64> = number(
    "largest fixed-point residual, relative to max(1, ‖C‖), at which an iterative solver stops before max_iterations; \
     0 = never",
    0.0,
    0.0,
    1.0,
);

/// Where a quadratic is to be minimised to the end by conjugate gradients: the residual relative to max(1, ‖C‖), below
/// which descent is hard to judge by values, and iterations that hardly any needs.
const EXACT: f64 = 1e-8;
const EXACT_ITERATIONS: usize = 5_000;

/// 1/L, the step for a gradient with the Lipschitz constant L; 1 for a data term without constraints, where any will do.
fn step(lipschitz: f64) -> f64 {
    if lipschitz > f64::MIN_POSITIVE { 1.0 / lipschitz } else { 1.0 }
}

/// The entries of W beside those of C.
fn entries(weights: &Mat<f64>, c: MatRef<'_, f64>) -> impl Iterator<Item = (f64, f64)> {
    weights.col_iter().zip(c.col_iter()).flat_map(|(w, c)| w.iter().copied().zip(c.iter().copied()))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Regulariser {
        serde_json::from_str(text).unwrap()
    }

    #[test]
    fn values_out_of_range_are_all_named() {
        let regulariser = Regulariser::L1(L1 { gamma: -1.0, max_iterations: 0, tolerance: f64::NAN });
        let fields: Vec<_> = regulariser.faults().into_iter().map(|(field, _)| field).collect();
        assert_eq!(fields, ["gamma", "max_iterations", "tolerance"]);
        assert_eq!(
            read(r#"{"type": "l2", "gamma": 2e9, "max_iterations": 20001, "tolerance": 2}"#).faults(),
            [
                ("gamma", "2000000000.0 is not between 0 and 1000000000".to_owned()),
                ("max_iterations", "20001.0 is not between 1 and 20000".to_owned()),
                ("tolerance", "2.0 is not between 0 and 1".to_owned()),
            ]
        );
    }

    #[test]
    fn the_ends_of_the_ranges_are_allowed() {
        assert!(read(r#"{"type": "none"}"#).faults().is_empty());
        assert!(Regulariser::L1(L1 { gamma: 0.0, max_iterations: 1, tolerance: 0.0 }).faults().is_empty());
        assert!(
            Regulariser::Nuclear(Nuclear { gamma: 1e9, max_iterations: 20_000, tolerance: 1.0 }).faults().is_empty()
        );
    }

    #[test]
    fn a_regulariser_is_read_with_the_defaults_it_is_described_with() {
        for about in ALL {
            let regulariser = read(&format!(r#"{{"type": "{}"}}"#, about.r#type));
            assert_eq!((regulariser.name(), regulariser.faults()), (about.r#type, vec![]));
            let written = serde_json::to_value(&regulariser).unwrap();
            assert_eq!(written.as_object().unwrap().len(), 1 + about.parameters.len());
            for parameter in about.parameters {
                let schema = serde_json::to_value(parameter.schema().build()).unwrap();
                assert_eq!(written[parameter.name], schema["default"], "{}", parameter.name);
            }
        }
    }

    #[test]
    fn what_no_regulariser_has_is_refused() {
        for text in [r#"{"type": "l1", "gama": 1}"#, r#"{"type": "none", "gamma": 1}"#, r#"{"type": "l3"}"#, "{}"] {
            assert!(serde_json::from_str::<Regulariser>(text).is_err(), "{text}");
        }
    }
}
