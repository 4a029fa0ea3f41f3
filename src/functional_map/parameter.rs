//! What a setting may be: one table for checks, descriptions and schemas.

use serde::Serialize;
use serde_json::json;
use utoipa::ToSchema;
use utoipa::openapi::schema::{ObjectBuilder, Type};

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

/// What a parameter is and may be, declared in one place beside the type of its values; its field gives it a name.
#[derive(Clone, Copy, Debug)]
pub struct Declared<T> {
    pub default: T,
    description: &'static str,
    domain: Domain,
}

impl<T> Declared<T> {
    pub const fn named(&self, name: &'static str) -> Parameter {
        Parameter { name, description: self.description, domain: self.domain }
    }
}

/// A number from `minimum` to `maximum`.
pub const fn number(description: &'static str, default: f64, minimum: f64, maximum: f64) -> Declared<f64> {
    let domain = Domain::Number { default, minimum, exclusive_minimum: false, maximum };
    Declared { default, description, domain }
}

/// A number above `minimum` and up to `maximum`.
pub const fn number_above(description: &'static str, default: f64, minimum: f64, maximum: f64) -> Declared<f64> {
    let domain = Domain::Number { default, minimum, exclusive_minimum: true, maximum };
    Declared { default, description, domain }
}

/// A whole number from `minimum` to `maximum`.
pub const fn integer(description: &'static str, default: usize, minimum: usize, maximum: usize) -> Declared<usize> {
    Declared { default, description, domain: Domain::Integer { default, minimum, maximum } }
}

/// One of some words, of which the first is that of the default.
pub const fn word<T: Copy>(description: &'static str, default: T, choices: &'static [&'static str]) -> Declared<T> {
    Declared { default, description, domain: Domain::String { default: choices[0], choices } }
}

/// A type of parameters, each with the type of its values and what is declared of it: written as an object, read strictly,
/// and where one is left out as its default.
macro_rules! parameters {
    ($(#[$about:meta])* pub struct $name:ident { $($field:ident: $type:ty = $declared:expr,)+ }) => {
        $(#[$about])*
        #[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct $name {
            $(pub $field: $type,)+
        }

        impl $name {
            /// What is declared of its fields, under their names.
            const PARAMETERS: &'static [$crate::functional_map::parameter::Parameter] =
                &[$($declared.named(stringify!($field)),)+];
        }

        impl Default for $name {
            fn default() -> $name {
                $name { $($field: $declared.default,)+ }
            }
        }
    };
}

pub(super) use parameters;

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

    /// The schema of its values.
    pub(super) fn schema(&self) -> ObjectBuilder {
        let schema = ObjectBuilder::new().description(Some(self.description));
        match self.domain {
            Domain::Number { default, minimum, exclusive_minimum, maximum } => {
                let schema = schema.schema_type(Type::Number).default(Some(json!(default))).maximum(Some(maximum));
                if exclusive_minimum { schema.exclusive_minimum(Some(minimum)) } else { schema.minimum(Some(minimum)) }
            }
            Domain::Integer { default, minimum, maximum } => {
                let schema = schema.schema_type(Type::Integer).default(Some(json!(default)));
                schema.minimum(Some(minimum)).maximum(Some(maximum))
            }
            Domain::String { default, choices } => {
                schema.schema_type(Type::String).default(Some(json!(default))).enum_values(Some(choices.to_vec()))
            }
        }
    }
}

fn outside(value: f64, minimum: f64, maximum: f64) -> Option<String> {
    (!(minimum..=maximum).contains(&value)).then(|| format!("{value:?} is not between {minimum} and {maximum}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    const CLOSED: Parameter = number("", 1.0, 0.0, 2.0).named("a");
    const OPEN: Parameter = number_above("", 1.0, 0.0, 2.0).named("b");

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
