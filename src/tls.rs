//! TLS of what goes out: calls of webhooks, buckets, spans.

use rustls::crypto::ring;

/// Makes ring the cryptography of all TLS of the process, unless another was chosen before. Whoever makes a client of HTTP says
/// so first: there is no other in the program, since one that is compiled from C takes minutes.
pub fn provide() {
    // An error says that it is done already.
    let _ = ring::default_provider().install_default();
}
