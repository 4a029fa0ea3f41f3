//! The regularisers there are, described for people and programs.

use serde::Serialize;
use serde_json::{Map, Value, json};
use utoipa::ToSchema;

use super::parameter::{Domain, Parameter};

/// A regulariser: the problem it makes, how that is solved, and its parameters.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct Description {
    /// The `type` in a request.
    pub r#type: &'static str,
    pub title: &'static str,
    /// What C minimises.
    pub formula: Formula,
    /// Number of the equation in the thesis.
    pub equation: &'static str,
    pub solver: &'static str,
    /// Without `type`.
    #[schema(value_type = Vec<Parameter>)]
    pub parameters: &'static [Parameter],
    /// JSON schema of the `regulariser` in a request.
    #[schema(value_type = Object)]
    pub schema: Value,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, ToSchema)]
pub struct Formula {
    pub text: &'static str,
    pub latex: &'static str,
}

/// Every regulariser a request can name, in the order of the thesis.
pub fn descriptions() -> Vec<Description> {
    vec![
        description(
            "none",
            "Least squares",
            Formula { text: "‖C A − B‖²_F", latex: r"\|CA - B\|_F^2" },
            "2.13",
            "exact: the solution of least norm",
        ),
        description(
            "l2",
            "Weighted squared entries",
            Formula {
                text: "‖C A − B‖²_F + γ ‖W ⊙ C‖²_F", latex: r"\|CA - B\|_F^2 + \gamma \|W \odot C\|_F^2"
            },
            "3.6",
            "exact row by row, or conjugate gradients (Hestenes and Stiefel) with backtracking",
        ),
        description(
            "l1",
            "Weighted absolute entries",
            Formula {
                text: "‖C A − B‖²_F + γ ‖W ⊙ C‖₁", latex: r"\|CA - B\|_F^2 + \gamma \|W \odot C\|_1"
            },
            "3.22",
            "fast proximal gradient: soft thresholding of entries",
        ),
        description(
            "nuclear",
            "Nuclear norm",
            Formula { text: "‖C A − B‖²_F + γ ‖C‖_*", latex: r"\|CA - B\|_F^2 + \gamma \|C\|_*" },
            "3.23",
            "fast proximal gradient: soft thresholding of singular values",
        ),
    ]
}

/// The parameters of the regulariser of this `type`; none of an unknown one.
pub(super) fn parameters(r#type: &str) -> &'static [Parameter] {
    const L2: &[Parameter] = &[gamma(10.0), MAX_ITERATIONS, TOLERANCE, SOLVER];
    const L1: &[Parameter] = &[gamma(1.0), MAX_ITERATIONS, TOLERANCE];
    const NUCLEAR: &[Parameter] = &[gamma(20.0), MAX_ITERATIONS, TOLERANCE];
    match r#type {
        "l2" => L2,
        "l1" => L1,
        "nuclear" => NUCLEAR,
        _ => &[],
    }
}

const fn gamma(default: f64) -> Parameter {
    Parameter {
        name: "gamma",
        description: "weight γ of the regularisation against the data term",
        domain: Domain::Number { default, minimum: 0.0, exclusive_minimum: false, maximum: 1e9 },
    }
}

const MAX_ITERATIONS: Parameter = Parameter {
    name: "max_iterations",
    description: "iterations after which an iterative solver stops",
    domain: Domain::Integer { default: 200, minimum: 1, maximum: 20_000 },
};

const TOLERANCE: Parameter = Parameter {
    name: "tolerance",
    description: "largest fixed-point residual, relative to max(1, ‖C‖), at which an iterative solver stops before \
                  max_iterations; 0 = never",
    domain: Domain::Number { default: 0.0, minimum: 0.0, exclusive_minimum: false, maximum: 1.0 },
};

const SOLVER: Parameter = Parameter {
    name: "solver",
    description: "both reach the same C; the exact one does not iterate",
    domain: Domain::String { default: "exact", choices: &["exact", "conjugate_gradient"] },
};

fn description(
    r#type: &'static str,
    title: &'static str,
    formula: Formula,
    equation: &'static str,
    solver: &'static str,
) -> Description {
    let parameters = parameters(r#type);
    Description { r#type, title, formula, equation, solver, parameters, schema: schema(r#type, parameters) }
}

fn schema(r#type: &str, parameters: &[Parameter]) -> Value {
    let mut properties = Map::from_iter([("type".to_owned(), json!({"const": r#type}))]);
    properties.extend(parameters.iter().map(|parameter| (parameter.name.to_owned(), parameter.schema())));
    json!({"type": "object", "properties": properties, "required": ["type"], "additionalProperties": false})
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::functional_map::regulariser::{Regulariser, faults};

    #[test]
    fn the_defaults_are_those_of_a_request_and_in_range() {
        for description in descriptions() {
            let regulariser: Regulariser = serde_json::from_value(json!({"type": description.r#type})).unwrap();
            assert!(faults(&regulariser).is_empty());
            let mut request = serde_json::to_value(&regulariser).unwrap();
            let request = request.as_object_mut().unwrap();
            request.remove("type");
            assert_eq!(request.len(), description.parameters.len());
            for parameter in description.parameters {
                assert_eq!(request[parameter.name], parameter.schema()["default"], "{}", parameter.name);
            }
        }
    }

    #[test]
    fn the_ranges_are_those_of_the_request_schema() {
        let schema = serde_json::to_value(<Regulariser as utoipa::PartialSchema>::schema()).unwrap();
        let variants = schema["oneOf"].as_array().unwrap();
        assert_eq!(variants.len(), descriptions().len());
        for (variant, description) in variants.iter().zip(descriptions()) {
            for parameter in description.parameters.iter().filter(|parameter| parameter.name != "solver") {
                let property = &variant["properties"][parameter.name];
                for bound in ["minimum", "maximum"] {
                    let (documented, listed) = (&property[bound], &parameter.schema()[bound]);
                    assert_eq!(documented.as_f64(), listed.as_f64(), "{} {}", parameter.name, bound);
                }
            }
        }
    }

    #[test]
    fn a_description_is_plain_json() {
        let l2 = serde_json::to_value(&descriptions()[1]).unwrap();
        assert_eq!(l2["type"], "l2");
        assert_eq!(
            l2["parameters"][0],
            json!({
                "name": "gamma", "description": "weight γ of the regularisation against the data term", "type": "number",
                "default": 10.0, "minimum": 0.0, "exclusive_minimum": false, "maximum": 1e9
            })
        );
        assert_eq!(l2["schema"]["properties"]["solver"]["enum"], json!(["exact", "conjugate_gradient"]));
    }
}
