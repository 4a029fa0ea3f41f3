//! Why something was not written.

use safetensors::tensor::SafeTensorError;

use crate::picture::Unfit;

/// Why something was not written.
#[derive(Debug, thiserror::Error)]
pub enum Unwritten {
    #[error("what is stored cannot be read or written as JSON: {0}")]
    Json(#[from] serde_json::Error),
    #[error("the result has no such alternative")]
    NoAlternative,
    #[error(transparent)]
    Unfit(#[from] Unfit),
    #[error("the picture cannot be encoded: {0}")]
    Picture(#[from] image::ImageError),
    #[error("the mesh cannot be encoded: {0}")]
    Mesh(#[from] gltf::Error),
    #[error("the arrays cannot be encoded: {0}")]
    Tensors(#[from] SafeTensorError),
}
