//! What is to be taken from one shape to the other, and what comes of it.

use std::borrow::Cow;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;
use utoipa::openapi::schema::{ArrayBuilder, ObjectBuilder, Type};

use super::Fault;
use crate::pipeline::settings::too_large;
use crate::regions::MAX_REGIONS;

/// Something given at the vertices of one shape of a match, to be taken to the other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct TransferRequest {
    pub from: Shape,
    #[serde(default)]
    pub by: By,
    /// By points from the sketch, and else refused: the mirrored alternative of the match answers for the other side of the body.
    #[serde(default)]
    pub both_sides: bool,
    pub given: Given,
}

/// One of the two shapes of a match.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Shape {
    Sketch,
    Mesh,
}

/// What it is taken by.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum By {
    /// The correspondences.
    #[default]
    Points,
    /// The functional map C; from the mesh Cᵀ.
    Map,
}

/// What is given, of a mesh at every vertex of the user's file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case", deny_unknown_fields)]
pub enum Given {
    /// A number for every vertex.
    Function { values: Vec<f64> },
    /// A label from 0 to 63 for every vertex; −1 is none.
    Labels { values: Vec<i32> },
    /// Red, green and blue in sRGB for every vertex, each from 0 to 1.
    Colours {
        #[schema(schema_with = colours_schema)]
        values: Vec<[f64; 3]>,
    },
    /// The colours of the drawing itself, of a picture or an SVG; from the sketch alone.
    Drawing {},
}

fn colours_schema() -> ArrayBuilder {
    let share = ObjectBuilder::new().schema_type(Type::Number).minimum(Some(0)).maximum(Some(1));
    ArrayBuilder::new().items(ArrayBuilder::new().items(share).min_items(Some(3)).max_items(Some(3)))
}

/// What has come of it at the vertices of the other shape, of a mesh at every vertex of the user's file; null where nothing
/// corresponds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "type", rename_all = "snake_case")]
pub enum Moved {
    Function {
        values: Vec<Option<f64>>,
    },
    /// −1 where nothing corresponds.
    Labels {
        values: Vec<i32>,
    },
    Colours {
        values: Vec<Option<[f64; 3]>>,
    },
}

/// What is given, looked up.
#[derive(Clone, Debug, PartialEq)]
pub enum Values<'a> {
    Function(&'a [f64]),
    Labels(&'a [i32]),
    Colours(Cow<'a, [[f64; 3]]>),
}

impl Given {
    /// What is given, with the colours of the drawing at the vertices of the sketch where it is those.
    pub fn values(&self, drawn: impl FnOnce() -> Vec<[f64; 3]>) -> Values<'_> {
        match self {
            Given::Function { values } => Values::Function(values),
            Given::Labels { values } => Values::Labels(values),
            Given::Colours { values } => Values::Colours(Cow::Borrowed(values)),
            Given::Drawing {} => Values::Colours(Cow::Owned(drawn())),
        }
    }

    /// What does not fit a shape of so many vertices.
    pub(super) fn faults(&self, vertices: usize) -> Vec<Fault> {
        let fault = |pointer: String, detail: String| Fault { pointer, detail };
        let mut faults = Vec::new();
        let (count, wrong) = match self {
            Given::Function { values } => (values.len(), too_large(values)),
            Given::Labels { values } => {
                let labels = -1..MAX_REGIONS as i32;
                let wrong = values.iter().position(|label| !labels.contains(label));
                (values.len(), wrong.map(|i| (i, format!("{} is not −1 to {}", values[i], MAX_REGIONS - 1))))
            }
            Given::Colours { values } => {
                let wrong = values.iter().position(|rgb| rgb.iter().any(|x| !(0.0..=1.0).contains(x)));
                (values.len(), wrong.map(|i| (i, "is not three numbers from 0 to 1".to_owned())))
            }
            Given::Drawing {} => (vertices, None),
        };
        if count != vertices {
            let detail = format!("must be one for each of the {vertices} vertices, are {count}");
            faults.push(fault("/given/values".to_owned(), detail));
        }
        faults.extend(wrong.map(|(i, detail)| fault(format!("/given/values/{i}"), detail)));
        faults
    }
}
