//! What of a document is not drawn, though a browser shows it.

use usvg::roxmltree::Document;

use super::nesting;
use crate::sketch::refusal::{Fault, Refusal, Warning, WarningCode};

/// Elements that are not drawn.
const KINDS: [&str; 3] = ["text", IMAGE, "foreignObject"];

const IMAGE: &str = "image";

/// The kinds of element in a document that are not drawn.
pub(in crate::sketch) struct Ignored(Vec<&'static str>);

impl Ignored {
    /// Those in this document; one without a namespace is drawn as an SVG too.
    pub fn of(document: &Document) -> Ignored {
        let is_present = |kind: &&str| {
            let mut nodes = document.descendants().map(|node| node.tag_name());
            nodes.any(|tag| tag.name() == *kind && matches!(tag.namespace(), None | Some(nesting::SVG)))
        };
        Ignored(KINDS.into_iter().filter(is_present).collect())
    }

    /// Why nothing is seen in a document that has nothing else.
    pub fn nothing_else(&self) -> Refusal {
        Refusal::plain(match &self.0[..] {
            [] => "the SVG shows nothing: no shape in it is filled or stroked".to_owned(),
            [IMAGE] => "the SVG shows an embedded image only: send that picture itself, as PNG or JPEG".to_owned(),
            kinds => format!("the SVG shows nothing but what is not drawn here: {}", kinds.join(", ")),
        })
    }

    /// That they were not looked at.
    pub fn warning(&self) -> Option<Warning> {
        let detail = format!("not drawn: {}", self.0.join(", "));
        (!self.0.is_empty()).then(|| Warning::new(WarningCode::IgnoredElements, detail))
    }

    /// Why the rest of the document is not taken: with a picture in it that is likely all that a person sees.
    pub fn told_with(&self, mut refusal: Refusal) -> Refusal {
        if self.0.contains(&IMAGE) {
            let detail =
                "the SVG has an embedded picture, which is not drawn here: send that picture itself, as PNG or JPEG";
            refusal.faults.insert(0, Fault::plain(detail));
        }
        refusal
    }
}
