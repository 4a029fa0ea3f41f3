//! A pose as a mesh and as a picture.

use std::io::Write;

use bytes::Bytes;
use safetensors::tensor::{Dtype, TensorView};
use serde::Deserialize;

use super::{Unwritten, picture};
use crate::mesh::file_mesh::FileMesh;
use crate::mesh::formats::Appearance;
use crate::picture::{posed_glb, posed_glb_in, posed_png};
use crate::posing::Basis;
use crate::sketch::Sketch;

/// What is read of a result.
#[derive(Deserialize)]
struct Poses {
    frames: Vec<Frame>,
}

#[derive(Deserialize)]
struct Frame {
    positions: Vec<[Option<f64>; 3]>,
    drawing: Vec<[f64; 2]>,
}

impl Frame {
    /// Where the vertices of the file are; not a number where the file has none.
    fn places(&self) -> Vec<[f64; 3]> {
        self.positions.iter().map(|p| p.map(|x| x.unwrap_or(f64::NAN))).collect()
    }
}

fn frame(result: &[u8], number: usize) -> Result<Frame, Unwritten> {
    let mut poses: Poses = serde_json::from_slice(result)?;
    if number < poses.frames.len() { Ok(poses.frames.swap_remove(number)) } else { Err(Unwritten::NoFrame) }
}

/// One frame of a result as Wavefront OBJ: the file the mesh was read of with its vertices in their new places, where that
/// was an OBJ, so that its faces, groups, texture coordinates and materials stay; else vertices and triangles. Its normals are
/// those of the mesh at rest, and left out: whatever shows it makes its own.
///
/// # Errors
/// A result that cannot be read or has no such frame.
pub fn obj(result: &[u8], number: usize, mesh: &FileMesh, file: Option<&[u8]>) -> Result<Bytes, Unwritten> {
    let places = frame(result, number)?.places();
    Ok(file.and_then(|file| moved(file, &places)).unwrap_or_else(|| plain(&places, mesh.triangles())).into())
}

/// An OBJ file with its vertices in other places; nothing where they are not told one a line.
fn moved(file: &[u8], places: &[[f64; 3]]) -> Option<Vec<u8>> {
    let mut written = Vec::with_capacity(file.len());
    let mut next = places.iter();
    let (mut keyword, mut goes_on): (&[u8], bool) = (b"", false);
    for line in file.split_inclusive(|&byte| byte == b'\n') {
        let text = line.trim_ascii();
        if !goes_on {
            keyword = text.split(u8::is_ascii_whitespace).next().unwrap_or_default();
        }
        goes_on = text.ends_with(b"\\");
        match keyword {
            b"v" if goes_on => return None,
            b"v" => {
                vertex(&mut written, next.next()?);
                // A weight or a colour stays.
                std::str::from_utf8(text).ok()?.split_ascii_whitespace().skip(4).for_each(|rest| {
                    written.push(b' ');
                    written.extend_from_slice(rest.as_bytes());
                });
                written.push(b'\n');
            }
            b"vn" => {}
            b"f" => face(&mut written, line, goes_on),
            _ => written.extend_from_slice(line),
        }
    }
    next.next().is_none().then_some(written)
}

/// Corners of a face without their normals; what is continued on the next line is brought to one.
fn face(written: &mut Vec<u8>, line: &[u8], goes_on: bool) {
    let text = line.trim_ascii_end();
    for word in text.strip_suffix(b"\\").unwrap_or(text).split_inclusive(u8::is_ascii_whitespace) {
        let corner = word.trim_ascii_end();
        let normal = (0..corner.len()).filter(|&at| corner[at] == b'/').nth(1).unwrap_or(corner.len());
        let kept = corner[..normal].strip_suffix(b"/").unwrap_or(&corner[..normal]);
        written.extend_from_slice(kept);
        written.extend_from_slice(&word[corner.len()..]);
    }
    written.extend_from_slice(if goes_on { b" " } else { &line[text.len()..] });
}

fn plain(places: &[[f64; 3]], triangles: &[[u32; 3]]) -> Vec<u8> {
    let mut written = Vec::new();
    for place in places {
        vertex(&mut written, place);
        written.push(b'\n');
    }
    for [a, b, c] in triangles.iter().map(|t| t.map(|v| v + 1)) {
        // Writing to memory cannot fail.
        let _ = writeln!(written, "f {a} {b} {c}");
    }
    written
}

fn vertex(written: &mut Vec<u8>, [x, y, z]: &[f64; 3]) {
    let _ = write!(written, "v {x} {y} {z}");
}

/// All frames of a result as glTF 2.0 binary: one is the mesh in its pose, several are morph targets of the mesh at rest with an
/// animation through them. Vertices and triangles are those of the user's file. Where that was glTF, binary or not, its texture
/// coordinates, materials and textures stay; else the mesh is white.
///
/// # Errors
/// A result that cannot be read; what the encoder reports.
pub fn glb(result: &[u8], mesh: &FileMesh, file: Option<&[u8]>) -> Result<Bytes, Unwritten> {
    let poses: Poses = serde_json::from_slice(result)?;
    let places: Vec<Vec<[f64; 3]>> = poses.frames.iter().map(Frame::places).collect();
    // A file that was read once and cannot be now is no reason against the pose.
    let appearance = file.and_then(|file| Appearance::of(file).ok().flatten());
    if let Some(appearance) = appearance
        && let Some(written) = posed_glb_in(mesh, appearance, &places)?
    {
        return Ok(written.into());
    }
    Ok(posed_glb(mesh, &places)?.into())
}

/// One frame of a result as a picture: the drawing, the mesh as it is seen in it, and the mesh from 60° beside, in the
/// colours of the match at rest, of which `matched` is the result.
///
/// # Errors
/// A result that cannot be read or has no such frame; what the encoder reports.
pub fn png(
    result: &[u8],
    number: usize,
    matched: &[u8],
    sketch: &Sketch,
    mesh: &FileMesh,
    width: u32,
) -> Result<Bytes, Unwritten> {
    let frame = frame(result, number)?;
    let places = frame.places();
    let own = mesh.origins().iter().map(|&v| places.get(v as usize).copied().unwrap_or([f64::NAN; 3])).collect();
    let drawing: Vec<[f64; 2]> = frame.drawing.iter().map(|&p| sketch.to_internal(p)).collect();
    Ok(posed_png(&picture::pair(matched, sketch, mesh)?, &drawing, own, width)?.into())
}

/// A basis in single precision: `basis` (n × 3 h), `rest` (n × 3), `places` (n × 2) and `axes` (2 × 3).
///
/// # Errors
/// What the encoder reports.
pub fn basis(Basis { values, places, axes }: &Basis, mesh: &FileMesh) -> Result<Bytes, Unwritten> {
    let bytes =
        |numbers: &mut dyn Iterator<Item = f64>| numbers.flat_map(|x| (x as f32).to_le_bytes()).collect::<Vec<u8>>();
    let n = mesh.positions().len();
    let values_bytes = bytes(&mut values.row_iter().flat_map(|row| row.iter().copied()));
    let rest = bytes(&mut mesh.positions().as_flattened().iter().copied());
    let places = bytes(&mut places.as_flattened().iter().copied());
    let axes = bytes(&mut axes.as_flattened().iter().copied());
    let views = [
        ("basis", TensorView::new(Dtype::F32, vec![n, values.ncols()], &values_bytes)?),
        ("rest", TensorView::new(Dtype::F32, vec![n, 3], &rest)?),
        ("places", TensorView::new(Dtype::F32, vec![n, 2], &places)?),
        ("axes", TensorView::new(Dtype::F32, vec![2, 3], &axes)?),
    ];
    Ok(safetensors::serialize(views, None)?.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TriangleMesh;

    const RESULT: &str = r#"{"frames": [
        {"positions": [[0, 0, 0.5], [1.25, 0, 0], [0, null, 0]], "drawing": []},
        {"positions": [[9, 0, 0], [1, 0, 0], [0, 1, 0]], "drawing": []}
    ]}"#;

    fn mesh() -> FileMesh {
        let positions = vec![[0., 0., 0.], [1., 0., 0.], [0., 1., 0.]];
        TriangleMesh::new(positions, vec![[0, 1, 2]]).unwrap().into()
    }

    fn written(number: usize, file: Option<&str>) -> String {
        let bytes = obj(RESULT.as_bytes(), number, &mesh(), file.map(str::as_bytes)).unwrap();
        String::from_utf8(bytes.to_vec()).unwrap()
    }

    #[test]
    fn an_obj_keeps_all_but_its_vertices_and_normals() {
        let file =
            "# cat\nmtllib cat.mtl\nvt 0 1\r\n  v 0 0 0\nv\t1 0 0 1.0 0.5 0.25\nv 0 1 0\nvn 0 0 1\nf 1/1 2/1 3/1\n";
        let expected = "# cat\nmtllib cat.mtl\nvt 0 1\r\nv 9 0 0\nv 1 0 0 1.0 0.5 0.25\nv 0 1 0\nf 1/1 2/1 3/1\n";
        assert_eq!(written(1, Some(file)), expected);
    }

    #[test]
    fn no_face_names_a_normal_of_the_mesh_at_rest() {
        let vertices = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
        for (file, kept) in [
            ("vn 0 0 1\nf 1//1 2//1 3//1\n", "f 1 2 3\n"),
            ("vn 0 \\\n0 1\ns 1\n f 1/1/1\t2/2/1 -1/3/-1\r\n", "s 1\n f 1/1\t2/2 -1/3\r\n"),
            ("f 1/1/1 \\\n2/2/1\\\n 3/3/1 # c", "f 1/1  2/2  3/3 # c"),
            ("f 1/ 2/ 3/", "f 1 2 3"),
        ] {
            assert_eq!(written(1, Some(&format!("{vertices}{file}"))), format!("v 9 0 0\nv 1 0 0\nv 0 1 0\n{kept}"));
        }
    }

    #[test]
    fn another_file_becomes_vertices_and_triangles() {
        let plain = "v 0 0 0.5\nv 1.25 0 0\nv 0 NaN 0\nf 1 2 3\n";
        for file in [
            None,
            Some("v 0 0 0\n"),
            Some("v 0 0 0\nv 1 0 \\\n0\nv 0 1 0\n"),
            Some("v 1 1 1\n v 1 1 1\nv 1 1 1\nv 1 1 1\n"),
        ] {
            assert_eq!(written(0, file), plain);
        }
    }

    #[test]
    fn there_is_no_frame_beyond_the_last() {
        assert!(matches!(obj(RESULT.as_bytes(), 2, &mesh(), None), Err(Unwritten::NoFrame)));
    }
}
