//! Why something was not written.

use safetensors::tensor::SafeTensorError;

use crate::picture::{PoseUnseen, Unfit};

/// Why something was not written.
#[derive(Debug, thiserror::Error)]
pub enum Unwritten {
    #[error("what is stored cannot be read or written as JSON: {0}")]
    Json(#[from] serde_json::Error),
    #[error("the result has no such alternative")]
    NoAlternative,
    #[error("the result has no such frame")]
    NoFrame,
    #[error("the pose cannot be drawn: {0}")]
    Pose(#[from] PoseUnseen),
    #[error(transparent)]
    Unfit(#[from] Unfit),
    #[error("the picture cannot be encoded: {0}")]
    Picture(#[from] image::ImageError),
    #[error("the mesh cannot be encoded: {0}")]
    Mesh(#[from] gltf::Error),
    #[error("the arrays cannot be encoded: {0}")]
    Tensors(#[from] SafeTensorError),
}
