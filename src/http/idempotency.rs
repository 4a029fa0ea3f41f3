//! `Idempotency-Key`: a request sent again under its key gets the first answer and is not carried out again.

use std::future::Future;

use axum::extract::FromRequestParts;
use axum::http::request::Parts;
use axum::http::{HeaderName, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;

use super::media_types::JSON;
use super::problem::{Fault, Problem};
use crate::store::{Remembered, Store};

const HEADER: HeaderName = HeaderName::from_static("idempotency-key");
const LONGEST_KEY: usize = 255;

/// The header, where the request has it.
pub struct IdempotencyKey(Option<String>);

impl<S: Send + Sync> FromRequestParts<S> for IdempotencyKey {
    type Rejection = Problem;

    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<IdempotencyKey, Problem> {
        let Some(value) = parts.headers.get(HEADER) else { return Ok(IdempotencyKey(None)) };
        match value.to_str() {
            Ok(key) if (1..=LONGEST_KEY).contains(&key.len()) && key.bytes().all(|byte| byte.is_ascii_graphic()) => {
                Ok(IdempotencyKey(Some(key.to_owned())))
            }
            _ => Err(Problem::malformed(Fault::in_header(
                HEADER.as_str(),
                "a key is 1 to 255 printable ASCII characters without spaces",
            ))),
        }
    }
}

/// An answer in JSON that can be given again.
pub struct Answer {
    pub status: StatusCode,
    pub location: Option<String>,
    pub body: Vec<u8>,
}

impl Answer {
    pub fn json(status: StatusCode, location: Option<String>, body: &impl Serialize) -> Result<Answer, Problem> {
        Ok(Answer { status, location, body: serde_json::to_vec(body).map_err(Problem::internal)? })
    }
}

impl IntoResponse for Answer {
    fn into_response(self) -> Response {
        let mut response = (self.status, [(header::CONTENT_TYPE, JSON)], self.body).into_response();
        let location = self.location.and_then(|location| HeaderValue::try_from(location).ok());
        response.headers_mut().extend(location.map(|location| (header::LOCATION, location)));
        response
    }
}

impl IdempotencyKey {
    /// The name under which a job of this request is queued once, even where the process dies before the answer is
    /// remembered.
    pub fn dedupe(&self, fingerprint: &str) -> Option<String> {
        self.0.as_ref().map(|key| format!("idempotent:{key}:{fingerprint}"))
    }

    /// The answer remembered for this key, else that of `answer`, which is then remembered. Refusals are not: they
    /// leave nothing behind that could happen twice.
    ///
    /// # Errors
    /// 422 where the key came with another request; whatever `answer` refuses.
    pub async fn once(
        &self,
        store: &Store,
        fingerprint: &str,
        answer: impl Future<Output = Result<Answer, Problem>>,
    ) -> Result<Answer, Problem> {
        let Some(key) = &self.0 else { return answer.await };
        // Of those that come at the same moment one is carried out, and the others find its answer.
        let _turn = store.turn(key).await;
        if let Some(answer) = known(store, key, fingerprint).await? {
            return Ok(answer);
        }
        let answer = answer.await?;
        let (status, location) = (answer.status.as_u16(), answer.location.as_deref());
        store.remember(key, fingerprint, status, location, &answer.body).await?;
        Ok(answer)
    }
}

/// The answer remembered for this key and request.
///
/// # Errors
/// 422 where the key came with another request.
async fn known(store: &Store, key: &str, fingerprint: &str) -> Result<Option<Answer>, Problem> {
    match store.remembered(key, fingerprint).await? {
        Remembered::New => Ok(None),
        Remembered::Same { status, location, body } => {
            let status = StatusCode::from_u16(status).map_err(Problem::internal)?;
            Ok(Some(Answer { status, location, body }))
        }
        Remembered::Different => {
            let fault = Fault::in_header(HEADER.as_str(), "this key was used for another request");
            Err(Problem::refused("the idempotency key is taken", vec![fault]))
        }
    }
}

/// What tells one request from another: its method and path (`call`), and a hash of its parts.
pub fn fingerprint(call: &str, parts: &[&[u8]]) -> String {
    let mut hasher = blake3::Hasher::new();
    for part in parts {
        hasher.update(&(part.len() as u64).to_le_bytes()).update(part);
    }
    format!("{call} {}", hasher.finalize().to_hex())
}
