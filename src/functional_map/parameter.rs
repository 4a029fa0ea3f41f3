//! What a setting may be: one table for checks, descriptions and schemas.

use serde::Serialize;
use serde_json::{Value, json};
use utoipa::ToSchema;

/// A setting, its default and its range.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, ToSchema)]
pub struct Parameter {
    pub name: &'static str,
    pub description: &'static str,
    #[serde(flatten)]
    pub domain: Domain,
}

/// The values a setting can take.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum Domain {
    /// A finite number from `minimum` to `maximum`, the minimum itself left out where it is exclusive.
    Number { default: f64, minimum: f64, exclusive_minimum: bool, maximum: f64 },
    /// A whole number from `minimum` to `maximum`.
    Integer { default: usize, minimum: usize, maximum: usize },
    /// One of the words of `enum`.
    String {
        default: &'static str,
        #[serde(rename = "enum")]
        choices: &'static [&'static str],
    },
}

impl Parameter {
    /// What is wrong with `value`, if anything; words are not judged here, they are parsed.
    pub fn fault(&self, value: f64) -> Option<String> {
        match self.domain {
            Domain::Number { minimum, exclusive_minimum: true, maximum, .. } => (!(value > minimum
                && value <= maximum))
                .then(|| format!("{value:?} is not above {minimum} and at most {maximum}")),
            Domain::Number { minimum, maximum, .. } => outside(value, minimum, maximum),
            Domain::Integer { minimum, maximum, .. } => outside(value, minimum as f64, maximum as f64),
            Domain::String { .. } => None,
        }
    }

    /// The JSON schema of its values.
    pub fn schema(&self) -> Value {
        let mut schema = match self.domain {
            Domain::Number { default, minimum, exclusive_minimum, maximum } => {
                let lower = if exclusive_minimum { "exclusiveMinimum" } else { "minimum" };
                json!({"type": "number", "default": default, lower: minimum, "maximum": maximum})
            }
            Domain::Integer { default, minimum, maximum } => {
                json!({"type": "integer", "default": default, "minimum": minimum, "maximum": maximum})
            }
            Domain::String { default, choices } => json!({"type": "string", "default": default, "enum": choices}),
        };
        schema["description"] = self.description.into();
        schema
    }
}

fn outside(value: f64, minimum: f64, maximum: f64) -> Option<String> {
    (!(minimum..=maximum).contains(&value)).then(|| format!("{value:?} is not between {minimum} and {maximum}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLOSED: Parameter = Parameter {
        name: "a",
        description: "",
        domain: Domain::Number { default: 1.0, minimum: 0.0, exclusive_minimum: false, maximum: 2.0 },
    };
    const OPEN: Parameter = Parameter {
        name: "b",
        description: "",
        domain: Domain::Number { default: 1.0, minimum: 0.0, exclusive_minimum: true, maximum: 2.0 },
    };

    #[test]
    fn ends_belong_to_a_range_unless_excluded() {
        assert_eq!(CLOSED.fault(0.0), None);
        assert_eq!(CLOSED.fault(2.0), None);
        assert_eq!(OPEN.fault(2.0), None);
        assert_eq!(OPEN.fault(0.0).unwrap(), "0.0 is not above 0 and at most 2");
        assert_eq!(CLOSED.fault(-0.5).unwrap(), "-0.5 is not between 0 and 2");
        assert_eq!(CLOSED.fault(1e300).unwrap(), "1e300 is not between 0 and 2");
    }

    #[test]
    fn what_is_not_a_number_is_out_of_range() {
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            assert!(CLOSED.fault(value).is_some() && OPEN.fault(value).is_some());
        }
    }
}
