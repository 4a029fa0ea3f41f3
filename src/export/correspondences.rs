//! The correspondences of a match as a table.

use bytes::Bytes;
use serde::Deserialize;

use super::Unwritten;

/// What a table of the correspondences needs of a result.
#[derive(Deserialize)]
struct Points {
    correspondences: Vec<Correspondence>,
}

#[derive(Deserialize)]
struct Correspondence {
    sketch_vertex: u64,
    point: [f64; 2],
    mesh_vertex: u64,
    confidence: Option<f64>,
}

/// The correspondences of a result as a table (RFC 4180) with a header; an empty field where a confidence is not known.
///
/// # Errors
/// A result that cannot be read.
pub fn csv(result: &[u8]) -> Result<Bytes, Unwritten> {
    let Points { correspondences } = serde_json::from_slice(result)?;
    let mut table = String::from("sketch_vertex,x,y,mesh_vertex,confidence\r\n");
    for Correspondence { sketch_vertex, point: [x, y], mesh_vertex, confidence, .. } in correspondences {
        let confidence = confidence.map(|value| value.to_string()).unwrap_or_default();
        table.push_str(&format!("{sketch_vertex},{x},{y},{mesh_vertex},{confidence}\r\n"));
    }
    Ok(table.into())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tabulates_correspondences() {
        let result = br#"{"correspondences": [{"sketch_vertex": 0, "point": [1.5, -2], "mesh_vertex": 7, "confidence": 0.5},
                                              {"sketch_vertex": 1, "point": [0, 0], "mesh_vertex": 8, "confidence": null}]}"#;
        let table = csv(result).unwrap();
        assert_eq!(table, "sketch_vertex,x,y,mesh_vertex,confidence\r\n0,1.5,-2,7,0.5\r\n1,0,0,8,\r\n");
    }
}
