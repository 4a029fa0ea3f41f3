//! Why a drawing was not taken, and what was mended in one that was.

use std::fmt;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// Faults named in one refusal: the first of them help, a thousand do not.
pub(super) const MAX_FAULTS: usize = 20;

/// Everything wrong with a drawing that no safe mending removes; at least one fault.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema, thiserror::Error)]
#[error("{}", Listed(faults))]
#[schema(as = SketchRefusal)]
pub struct Refusal {
    pub faults: Vec<Fault>,
}

/// One thing wrong with a drawing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = SketchFault)]
pub struct Fault {
    /// JSON pointer into the uploaded document, such as `/outline/17`; absent for pictures and SVG.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub pointer: Option<String>,
    /// Where it is, in the coordinates of the upload.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<Vec<f64>>, min_items = 2, max_items = 2)]
    pub point: Option<[f64; 2]>,
    /// What was asked for beside the drawing, where that is to blame: `figure`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub asked: Option<String>,
    /// What is wrong: lower case, without full stop.
    pub detail: String,
}

/// Something that was mended or left out on the way to a sketch.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = SketchWarning)]
pub struct Warning {
    pub code: WarningCode,
    /// What was done and where: lower case, without full stop.
    pub detail: String,
    /// Where it is, in the coordinates of the upload.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schema(value_type = Option<Vec<f64>>, min_items = 2, max_items = 2)]
    pub point: Option<[f64; 2]>,
    /// Lowest and highest corner of the box it lies in, in the coordinates of the upload.
    #[serde(default, skip_serializing_if = "Option::is_none", rename = "box")]
    #[schema(value_type = Option<Vec<Vec<f64>>>, min_items = 2, max_items = 2)]
    pub bounds: Option<[[f64; 2]; 2]>,
}

/// The kinds of [`Warning`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
#[schema(as = SketchWarningCode)]
pub enum WarningCode {
    /// The last point of a ring repeats the first.
    ClosingPointRepeated,
    /// Consecutive points at one place were made one.
    RepeatedPoints,
    /// Points in the middle of a straight line were left out.
    CollinearPoints,
    /// Parts of no width, out and back, were left out.
    Spikes,
    /// Small loops where a ring crosses itself were left out.
    SelfCrossing,
    /// Detail too fine for the wanted number of vertices was left out.
    Simplified,
    /// The smallest angle asked for was given up to keep thin parts at the wanted number of vertices.
    ThinParts,
    /// A figure beside the one that was taken was left out.
    OtherFigure,
    /// Something drawn was left out.
    LeftOut,
    /// The figure runs into the border and was closed along it.
    CutByBorder,
    /// A frame, a paper, a window was taken for what the figure is drawn on.
    Background,
    /// A gap in a line that encloses the figure was closed.
    ClosedGap,
    /// Parts of the figure that lie apart were joined.
    JoinedParts,
    /// A line that encloses nothing was made a limb of some width.
    LineAsLimb,
    /// Elements that are not drawn (text, images) and style that is not read (`@media`) were not looked at.
    IgnoredElements,
}

impl Refusal {
    /// A refusal for one reason without a place.
    pub fn plain(detail: impl Into<String>) -> Self {
        Self { faults: vec![Fault::plain(detail)] }
    }
}

impl Fault {
    /// A fault of the drawing as a whole.
    pub fn plain(detail: impl Into<String>) -> Self {
        Self { pointer: None, point: None, asked: None, detail: detail.into() }
    }

    /// A fault of the figure that was asked for.
    pub fn of_figure(detail: impl Into<String>) -> Self {
        Self { asked: Some("figure".to_owned()), ..Self::plain(detail) }
    }

    /// A fault of the member that `pointer` names.
    pub fn of(pointer: impl Into<String>, detail: impl Into<String>) -> Self {
        Self { pointer: Some(pointer.into()), ..Self::plain(detail) }
    }

    /// The same fault at a point of the drawing.
    pub fn at(self, point: [f64; 2]) -> Self {
        Self { point: Some(point), ..self }
    }
}

impl Warning {
    pub(super) fn new(code: WarningCode, detail: impl Into<String>) -> Self {
        Self { code, detail: detail.into(), point: None, bounds: None }
    }
}

impl Warning {
    /// The same warning of a point of the drawing.
    pub(super) fn at(self, point: [f64; 2]) -> Self {
        Self { point: Some(point), ..self }
    }

    /// The same warning of a box of the drawing.
    pub(super) fn within(self, bounds: [[f64; 2]; 2]) -> Self {
        Self { bounds: Some(bounds), ..self }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(pointer) = &self.pointer {
            write!(out, "{pointer}: ")?;
        }
        write!(out, "{}", self.detail)?;
        match self.point {
            Some([x, y]) => write!(out, " at ({x}, {y})"),
            None => Ok(()),
        }
    }
}

struct Listed<'a>(&'a [Fault]);

impl fmt::Display for Listed<'_> {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, fault) in self.0.iter().enumerate() {
            write!(out, "{}{fault}", if i > 0 { "; " } else { "" })?;
        }
        Ok(())
    }
}
