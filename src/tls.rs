//! TLS of what goes out: calls of webhooks, buckets, spans.

use rustls::crypto::ring;

/// Makes ring the cryptography of all TLS of the process, unless another was chosen before. Whoever makes a client of HTTP says
/// so first: the program has no other, and none is chosen by itself.
pub fn provide() {
    // An error says that it is done already.
    let _ = ring::default_provider().install_default();
}
