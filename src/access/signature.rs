//! Addresses that let in whoever has them, for a while: for what in a browser cannot send a header.

use std::time::{Duration, SystemTime};

use base64::Engine;
use base64::prelude::BASE64_URL_SAFE_NO_PAD;
use blake3::Hash;

use super::Tenant;

/// What is signed begins with this, so that the secret is good for nothing else.
const PURPOSE: &str = "sketchmatch link";

/// Signs addresses by a secret: the keyed hash of blake3 is a code that nobody without the secret can write.
#[derive(Clone, Debug)]
pub struct Signer {
    secret: [u8; 32],
}

impl Signer {
    pub fn new(secret: [u8; 32]) -> Signer {
        Signer { secret }
    }

    /// What lets in to what a tenant has at `resource` and below until `expires`, to the second.
    pub fn sign(&self, tenant: &Tenant, resource: &str, expires: SystemTime) -> String {
        let expires = seconds(expires);
        let code = BASE64_URL_SAFE_NO_PAD.encode(self.code(tenant, resource, expires).as_bytes());
        format!("{expires}.{code}.{tenant}")
    }

    /// Whose things at `resource` a signature opens now; nobody's where it is false, of another resource, or too old.
    pub fn opened(&self, signature: &str, resource: &str, now: SystemTime) -> Option<Tenant> {
        let mut parts = signature.splitn(3, '.');
        let expires: u64 = parts.next()?.parse().ok()?;
        let code: [u8; 32] = BASE64_URL_SAFE_NO_PAD.decode(parts.next()?).ok()?.try_into().ok()?;
        let tenant: Tenant = parts.next()?.parse().ok()?;
        // Hashes are compared in constant time.
        let written = Hash::from_bytes(code) == self.code(&tenant, resource, expires);
        (written && seconds(now) < expires).then_some(tenant)
    }

    fn code(&self, tenant: &Tenant, resource: &str, expires: u64) -> Hash {
        // None of them has a line in it, so that they cannot run into each other.
        let signed = format!("{PURPOSE}\n{tenant}\n{resource}\n{expires}");
        blake3::keyed_hash(&self.secret, signed.as_bytes())
    }
}

fn seconds(time: SystemTime) -> u64 {
    time.duration_since(SystemTime::UNIX_EPOCH).unwrap_or(Duration::ZERO).as_secs()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_signature_opens_one_resource_of_one_tenant_for_a_while() {
        let signer = Signer::new([7; 32]);
        let tenant: Tenant = "acme.org".parse().unwrap();
        let now = SystemTime::UNIX_EPOCH + Duration::from_secs(1_000_000_000);
        let signature = signer.sign(&tenant, "/v1/matches/1", now + Duration::from_secs(60));
        assert_eq!(signer.opened(&signature, "/v1/matches/1", now), Some(tenant));
        assert_eq!(signer.opened(&signature, "/v1/matches/2", now), None);
        assert_eq!(signer.opened(&signature, "/v1/matches/1", now + Duration::from_secs(60)), None);
        assert_eq!(Signer::new([8; 32]).opened(&signature, "/v1/matches/1", now), None);

        let later = signature.replacen("1000000060", "2000000060", 1);
        let other = signature.replace("acme", "umbrella");
        let turned = signature.chars().rev().collect();
        for forged in [later, other, turned, String::new(), "..".to_owned(), "1000000060..acme.org".to_owned()] {
            assert_eq!(signer.opened(&forged, "/v1/matches/1", now), None, "{forged}");
        }
    }
}
