use std::time::{Duration, SystemTime, UNIX_EPOCH};

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use bytes::Bytes;
use hmac::{Hmac, KeyInit, Mac};
use sha2::Sha256;

/// What a receiver is told.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Message {
    /// The same at every try, by which a receiver knows what it was told before.
    pub id: String,
    pub body: Bytes,
}

/// The secret as receivers are given it, for the libraries of Standard Webhooks.
pub fn secret_as_text(secret: &[u8; 32]) -> String {
    format!("whsec_{}", BASE64_STANDARD.encode(secret))
}

impl Message {
    /// What proves, to whoever has the secret, whose message it is and that it was sent at `seconds` since 1970.
    pub fn signature(&self, secret: &[u8; 32], seconds: u64) -> String {
        let seconds = seconds.to_string();
        // Unwrap safety: HMAC takes keys of every length, so that the fallback, an empty signature, is never sent.
        let code = Hmac::<Sha256>::new_from_slice(secret).map(|mut code| {
            for part in [self.id.as_bytes(), b".", seconds.as_bytes(), b".", &self.body] {
                code.update(part);
            }
            BASE64_STANDARD.encode(code.finalize().into_bytes())
        });
        format!("v1,{}", code.unwrap_or_default())
    }

    /// The headers of the message when it is sent at `now`.
    pub(super) fn headers(&self, secret: &[u8; 32], now: SystemTime) -> [(&'static str, String); 3] {
        let seconds = now.duration_since(UNIX_EPOCH).unwrap_or(Duration::ZERO).as_secs();
        [
            ("webhook-id", self.id.clone()),
            ("webhook-timestamp", seconds.to_string()),
            ("webhook-signature", self.signature(secret, seconds)),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Computed by Python's `hmac`: base64(hmac_sha256(bytes(range(32)), b"job-1.1700000000." + body)).
    #[test]
    fn a_message_is_signed_with_its_time() {
        let message = Message { id: "job-1".to_owned(), body: Bytes::from_static(br#"{"type":"match.succeeded"}"#) };
        let secret: [u8; 32] = std::array::from_fn(|i| i as u8);
        let at = |seconds| message.headers(&secret, UNIX_EPOCH + Duration::from_secs(seconds));
        let signed = [
            ("webhook-id", "job-1".to_owned()),
            ("webhook-timestamp", "1700000000".to_owned()),
            ("webhook-signature", "v1,+gy5wmYnsfvstqxLPKLk6hqlIqIy1hQGu/kThS0WYTQ=".to_owned()),
        ];
        assert_eq!(at(1_700_000_000), signed);
        assert_ne!(at(1_700_000_001)[2], signed[2]);
        assert_ne!(message.signature(&[0; 32], 1_700_000_000), signed[2].1);
        assert_eq!(secret_as_text(&secret), "whsec_AAECAwQFBgcICQoLDA0ODxAREhMUFRYXGBkaGxwdHh8=");
    }
}
