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
            return Fault::in_query(named_field(&detail).unwrap_or(&path), &detail);
        }
        cause = error.source();
    }
    Fault::at_place("query string", rejection.to_string())
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
