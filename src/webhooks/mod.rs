//! Calls that tell others of the end of a job: to whom they may go, how they are signed, and how they are made.
//!
//! Signed as [Standard Webhooks](https://www.standardwebhooks.com) has it, so that receivers find libraries that check it.

mod address;
mod caller;
mod hosts;
mod signature;

pub use caller::{Caller, Refused};
pub use hosts::{Host, Hosts};
pub use signature::{Message, secret_as_text};
