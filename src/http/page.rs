//! Lists in pages.

use axum::Json;
use axum::http::{HeaderValue, header};
use axum::response::{IntoResponse, Response};
use serde::{Deserialize, Serialize};
use utoipa::{IntoParams, ToSchema};

use super::problem::{Fault, Problem};
use crate::store::{self, StoreError};

const DEFAULT_LIMIT: u32 = 20;
const LARGEST_LIMIT: u32 = 100;

/// Which part of a list is asked for.
#[derive(Debug, Deserialize, IntoParams)]
#[serde(deny_unknown_fields)]
#[into_params(parameter_in = Query)]
pub struct PageQuery {
    /// Number of items; 20 where it is not given.
    #[param(minimum = 1, maximum = 100)]
    limit: Option<u32>,
    /// Where the page before ended: taken from its `next`.
    #[param(pattern = r"^[0-9]{1,18}\.")]
    after: Option<String>,
}

/// One page of a list, newest first.
#[derive(Debug, Serialize, ToSchema)]
pub struct Listing<T> {
    pub items: Vec<T>,
    /// The address of the next page, where there is one.
    pub next: Option<String>,
}

impl PageQuery {
    /// What to ask the store for: one item more than is shown tells whether another page follows.
    pub fn page(&self) -> Result<store::Page, Problem> {
        let limit = self.limit.unwrap_or(DEFAULT_LIMIT);
        if !(1..=LARGEST_LIMIT).contains(&limit) {
            let fault = Fault::in_query("limit", format!("the limit is from 1 to {LARGEST_LIMIT}"));
            return Err(Problem::refused("the page is not acceptable", vec![fault]));
        }
        Ok(store::Page { after: self.after.clone(), limit: limit + 1 })
    }

    /// The page of `found` items at `path`; `cursor` is what `after` says to go on after an item.
    pub fn listing<F, T: Serialize>(
        &self,
        path: &str,
        mut found: Vec<F>,
        cursor: fn(&F) -> String,
        item: fn(F) -> Result<T, Problem>,
    ) -> Result<Response, Problem> {
        let limit = self.limit.unwrap_or(DEFAULT_LIMIT);
        let more = found.len() > limit as usize;
        found.truncate(limit as usize);
        let next = found.last().filter(|_| more).map(|last| format!("{path}?limit={limit}&after={}", cursor(last)));
        let link = next.as_ref().and_then(|next| HeaderValue::try_from(format!("<{next}>; rel=\"next\"")).ok());
        let items = found.into_iter().map(item).collect::<Result<Vec<T>, Problem>>()?;
        let mut response = Json(Listing { items, next }).into_response();
        response.headers_mut().extend(link.map(|link| (header::LINK, link)));
        Ok(response)
    }
}

/// A cursor that is none of ours is the client's fault, everything else the store's.
pub fn cursor_fault(error: StoreError) -> Problem {
    match error {
        StoreError::Cursor => {
            let fault = Fault::in_query("after", "this is not where a page ended");
            Problem::refused("the page is not acceptable", vec![fault])
        }
        error => error.into(),
    }
}
