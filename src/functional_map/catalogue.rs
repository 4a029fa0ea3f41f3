//! The regularisers, terms and bases there are, described for people and programs.

use serde::Serialize;
use serde_json::Value;
use utoipa::ToSchema;

use super::parameter::{Parameter, number_above};
use super::regulariser::{self, About, Formula};
use super::term;

/// A regulariser or a term: the problem it makes, how that is solved, and its parameters.
#[derive(Clone, Debug, PartialEq, Serialize, ToSchema)]
pub struct Description {
    /// The `type` in a request.
    pub r#type: &'static str,
    pub title: &'static str,
    /// What C minimises; of a term what it adds to that.
    pub formula: Formula,
    /// Number of the equation in the thesis; empty where it has none.
    pub equation: &'static str,
    pub solver: &'static str,
    /// Without `type`.
    #[schema(value_type = Vec<Parameter>)]
    pub parameters: &'static [Parameter],
    /// JSON schema of the `regulariser`, or of one of the `terms`, in a request.
    #[schema(value_type = Object)]
    pub schema: Value,
}

/// Every regulariser a request can name, in the order of the thesis.
pub fn descriptions() -> Vec<Description> {
    regulariser::ALL.iter().map(|about| description(about)).collect()
}

/// Every term a request can name.
pub fn terms() -> Vec<Description> {
    term::ALL.iter().map(|about| description(about)).collect()
}

/// Every kind of basis a request can name, by the `method` of its `basis.coupling`.
pub fn bases() -> Vec<Description> {
    BASES.iter().map(|about| Description { schema: method_schema(about), ..description(about) }).collect()
}

/// The bases: a parameter of the request beside k, k_mesh and the boundary condition.
const BASES: [About; 2] = [
    About {
        r#type: "none",
        title: "Eigenfunctions of the Laplacian",
        formula: Formula { text: "S φ = λ A φ", latex: r"S \varphi = \lambda A \varphi" },
        equation: "2.10",
        solver: "block Lanczos",
        parameters: &[],
    },
    About {
        r#type: "joint_diagonalisation",
        title: "Coupled bases by joint diagonalisation",
        formula: Formula {
            text: "off(Pᵀ Λ_M P) + off(Qᵀ Λ_N Q) + w ‖Pᵀ A − Qᵀ B‖²_F, P and Q orthogonal",
            latex: r"\operatorname{off}(P^T \Lambda_M P) + \operatorname{off}(Q^T \Lambda_N Q) + w \|P^T A - Q^T B\|_F^2",
        },
        equation: "",
        solver: "gradient descent on the orthogonal group",
        parameters: &[COUPLING_WEIGHT],
    },
];

const COUPLING_WEIGHT: Parameter =
    number_above("weight w of the functions against the Laplacians", 1.0, 0.0, 1e6).named("weight");

/// The schema of a `basis.coupling`, whose tag is its `method`.
fn method_schema(about: &About) -> Value {
    let mut schema = serde_json::to_value(about.schema().build()).unwrap_or_default();
    let tag = schema["properties"].as_object_mut().and_then(|properties| properties.remove("type"));
    schema["properties"]["method"] = tag.unwrap_or_default();
    schema["required"] = serde_json::json!(["method"]);
    schema
}

fn description(about: &About) -> Description {
    let &About { r#type, title, formula, equation, solver, parameters } = about;
    let schema = serde_json::to_value(about.schema().build()).unwrap_or_default();
    Description { r#type, title, formula, equation, solver, parameters, schema }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

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
        assert_eq!(l2["schema"]["properties"]["type"]["enum"], json!(["l2"]));
        assert_eq!(l2["schema"]["properties"]["gamma"]["default"], json!(10.0));
        assert_eq!(l2["schema"]["properties"]["solver"]["enum"], json!(["exact", "conjugate_gradient"]));
        assert_eq!(
            (&l2["schema"]["required"], &l2["schema"]["additionalProperties"]),
            (&json!(["type"]), &json!(false))
        );
    }
}
