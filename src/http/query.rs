//! Query strings and path parameters.

use std::error::Error;

use axum::extract::{FromRequestParts, Path};
use axum::http::request::Parts;
use serde::de::DeserializeOwned;

use super::problem::{Fault, Problem};
use crate::intake::json::named_field;
use crate::store::is_text;

/// The query string as a `T`; an unknown, repeated or unreadable parameter is a 422 that names it.
pub struct Query<T>(pub T);

impl<T: DeserializeOwned, S: Send + Sync> FromRequestParts<S> for Query<T> {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Query<T>, Problem> {
        match axum::extract::Query::try_from_uri(&parts.uri) {
            Ok(axum::extract::Query(value)) => Ok(Query(value)),
            Err(rejection) => Err(Problem::refused("the query string is not acceptable", vec![fault(&rejection)])),
        }
    }
}

/// The fault behind a refused query string: the parameter's name is on the path serde was on.
fn fault(rejection: &(dyn Error + 'static)) -> Fault {
    type Tracked = serde_path_to_error::Error<serde::de::value::Error>;
    let mut cause = Some(rejection);
    while let Some(error) = cause {
        if let Some(error) = error.downcast_ref::<Tracked>() {
            let (path, detail) = (error.path().to_string(), error.inner().to_string());
            return Fault::in_query(named_field(&detail).unwrap_or(&path), worded(&detail));
        }
        cause = error.source();
    }
    Fault::at_place("query string", rejection.to_string())
}

/// A message of Rust in words: what it says of a number tells nobody what was wanted.
fn worded(detail: &str) -> &str {
    match detail {
        "invalid digit found in string" | "cannot parse integer from empty string" => {
            "expected a whole number from 0 on"
        }
        "invalid float literal" | "cannot parse float from empty string" => "expected a number",
        "provided string was not `true` or `false`" => "expected true or false",
        "number too large to fit in target type" => "the number is too large",
        detail => detail,
    }
}

/// The one parameter of the path. What cannot be an identifier, such as what PostgreSQL takes for no text, names nothing, which is a
/// 404.
pub struct Id(pub String);

impl<S: Send + Sync> FromRequestParts<S> for Id {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Id, Problem> {
        match Path::<String>::from_request_parts(parts, state).await {
            Ok(Path(id)) if is_text(&id) => Ok(Id(id)),
            _ => Err(Problem::not_found("resource of this name")),
        }
    }
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;

    #[derive(Deserialize)]
    struct Asked {
        #[expect(dead_code)]
        k: Option<usize>,
        #[expect(dead_code)]
        width: Option<f64>,
        #[expect(dead_code)]
        temporary: Option<bool>,
    }

    #[tokio::test]
    async fn what_a_parameter_is_to_be_is_said_in_words() {
        for (query, name, detail) in [
            ("k=few", "k", "expected a whole number from 0 on"),
            ("k=20.5", "k", "expected a whole number from 0 on"),
            ("k=", "k", "expected a whole number from 0 on"),
            ("width=wide", "width", "expected a number"),
            ("temporary=1", "temporary", "expected true or false"),
        ] {
            let (mut parts, ()) = axum::http::Request::get(format!("/?{query}")).body(()).unwrap().into_parts();
            let refused = Query::<Asked>::from_request_parts(&mut parts, &()).await.err().unwrap();
            assert_eq!(refused.errors, [Fault::in_query(name, detail)], "{query}");
        }
    }
}
