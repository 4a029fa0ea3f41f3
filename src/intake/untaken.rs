//! Why something is not taken.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::pipeline;

/// Why something is not taken, and every place in it that is to blame.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Untaken {
    pub cause: Cause,
    pub detail: String,
    /// Every fault found, with its place.
    pub faults: Vec<Fault>,
}

/// Who or what is to blame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// It is of a kind that is not understood.
    Unsupported,
    /// It is larger than what is taken.
    TooLarge,
    /// It is not what it says it is.
    Malformed,
    /// It is understood, but not acceptable.
    Unacceptable,
    /// The fault is ours: the detail is for the log.
    Failed,
}

/// One fault and its place: a JSON pointer into the request's body, or the name of a place outside it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[schema(as = ProblemFault)]
pub struct Fault {
    /// JSON pointer (RFC 6901) into the body.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pointer: Option<String>,
    /// A place no pointer reaches: a query parameter, a header, a line or face of a file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub place: Option<String>,
    pub detail: String,
}

impl Fault {
    pub fn at_pointer(pointer: impl Into<String>, detail: impl Into<String>) -> Fault {
        Fault { pointer: Some(pointer.into()), place: None, detail: detail.into() }
    }

    pub fn at_place(place: impl Into<String>, detail: impl Into<String>) -> Fault {
        Fault { pointer: None, place: Some(place.into()), detail: detail.into() }
    }

    /// A fault of the query parameter `name`.
    pub fn in_query(name: &str, detail: impl Into<String>) -> Fault {
        Fault::at_place(format!("query parameter {name}"), detail)
    }

    /// A fault of the header `name`.
    pub fn in_header(name: &str, detail: impl Into<String>) -> Fault {
        Fault::at_place(format!("header {name}"), detail)
    }
}

impl From<pipeline::Fault> for Fault {
    fn from(fault: pipeline::Fault) -> Fault {
        Fault::at_pointer(fault.pointer, fault.detail)
    }
}

impl Untaken {
    /// Something that cannot be read, for one reason.
    pub fn malformed(fault: Fault) -> Untaken {
        Untaken { cause: Cause::Malformed, detail: fault.detail.clone(), faults: vec![fault] }
    }

    /// Something that can be read and is not acceptable.
    pub fn unacceptable(detail: impl Into<String>, faults: Vec<Fault>) -> Untaken {
        Untaken { cause: Cause::Unacceptable, detail: detail.into(), faults }
    }

    /// Something that is not taken for a cause without a place.
    pub fn of(cause: Cause, detail: impl Into<String>) -> Untaken {
        Untaken { cause, detail: detail.into(), faults: Vec::new() }
    }

    /// The same, where something of another type stands at a pointer than these words say.
    pub fn expecting(mut self, at: &str, words: &str) -> Untaken {
        for fault in self.faults.iter_mut().filter(|fault| fault.pointer.as_deref() == Some(at)) {
            if let Some((found, _)) = fault.detail.split_once(", expected ") {
                fault.detail = format!("{found}, expected {words}");
            }
        }
        self
    }

    /// The same of a value that stands at a pointer of a larger one.
    pub fn below(mut self, at: &str) -> Untaken {
        for fault in &mut self.faults {
            fault.pointer = fault.pointer.take().map(|pointer| format!("{at}{pointer}"));
        }
        self
    }
}
