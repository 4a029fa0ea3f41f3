//! A client of HTTP.

use reqwest::Client;
use sketchmatch::tls;

/// A client without settings.
pub fn client() -> Client {
    tls::provide();
    Client::new()
}
