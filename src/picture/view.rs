//! Where the mesh is looked at from.

use faer::{Mat, Side};

use super::Matched;
use crate::geometry::dot;
use crate::geometry::frame::Frame;
use crate::mesh::normals::vertex_normals;

/// How far the second view is turned about the picture's up axis, in degrees.
const TURN: f64 = 60.0;

/// Sketch and view agree where their correlation is at least this; below it the picture keeps its roll.
const AGREES: f64 = 0.5;

/// The view the sketch was matched in, rolled so that the mesh stands in the picture as the sketch does. Where no view
/// is known, the matched vertices are looked at along their shortest principal axis, from the side from which they look
/// more like the sketch, of equals from the one that more of them face.
pub fn matched(pair: &Matched<'_>) -> Frame {
    let upright = |frame: Frame| {
        let Likeness { turn, correlation } = likeness(pair, &frame);
        let (sin, cos) = if correlation >= AGREES { turn.sin_cos() } else { (0.0, 1.0) };
        (frame.rolled([cos, sin]), correlation)
    };
    if let Some(view) = pair.view {
        return upright(view).0;
    }
    let front = broadest(pair);
    let [(front, alike), (behind, more_alike)] = [front, front.from_behind()].map(upright);
    if more_alike > alike { behind } else { front }
}

/// The view from 60° to the right of another, with the same up.
pub fn turned(frame: &Frame) -> Frame {
    let (sin, cos) = TURN.to_radians().sin_cos();
    let Frame { right, up, toward_camera } = *frame;
    Frame {
        right: std::array::from_fn(|i| cos * right[i] - sin * toward_camera[i]),
        up,
        toward_camera: std::array::from_fn(|i| cos * toward_camera[i] + sin * right[i]),
    }
}

/// The view of the matched vertices along the axis on which they vary least.
fn broadest(pair: &Matched<'_>) -> Frame {
    let positions = pair.mesh.positions();
    let points: Vec<[f64; 3]> = pair.vertices.iter().map(|&v| positions[v as usize]).collect();
    let centre = mean(&points);
    // Products of two coordinates of 1e50 are far from the largest number.
    let mut covariance = Mat::<f64>::zeros(3, 3);
    for p in &points {
        for i in 0..3 {
            for j in 0..3 {
                covariance[(i, j)] += (p[i] - centre[i]) * (p[j] - centre[j]);
            }
        }
    }
    // Eigenvalues ascend. A matrix that has none to be found is looked at along z.
    let axis = match covariance.self_adjoint_eigen(Side::Lower) {
        Ok(eigen) => [0, 1, 2].map(|i| eigen.U()[(i, 0)]),
        Err(_) => [0.0, 0.0, 1.0],
    };
    let normals = vertex_normals(pair.mesh);
    let facing: f64 = pair.vertices.iter().map(|&v| dot(normals[v as usize], axis)).sum();
    Frame::looking_from(if facing < 0.0 { axis.map(|x| -x) } else { axis })
}

/// How the picture of the matched vertices in a frame relates to the sketch.
struct Likeness {
    /// The angle by which it is turned against the sketch, counter-clockwise in radians: that of the best rotation.
    turn: f64,
    /// Of sketch and picture after that rotation, in `[0, 1]`; not a number where all points are one or none is believed.
    correlation: f64,
}

/// Points are weighted by confidence.
fn likeness(pair: &Matched<'_>, frame: &Frame) -> Likeness {
    let positions = pair.mesh.positions();
    let drawn: Vec<[f64; 2]> = pair.sketch.mesh().positions().iter().map(|&[x, y, _]| [x, y]).collect();
    let seen: Vec<[f64; 2]> = pair.vertices.iter().map(|&v| frame.project(positions[v as usize])).collect();
    let (p0, q0) = (mean(&drawn), mean(&seen));
    let (mut cosine, mut sine, mut drawn_norm, mut seen_norm) = (0.0, 0.0, 0.0, 0.0);
    for ((p, q), weight) in drawn.iter().zip(&seen).zip(&pair.confidence) {
        let ([px, py], [qx, qy]) = ([p[0] - p0[0], p[1] - p0[1]], [q[0] - q0[0], q[1] - q0[1]]);
        cosine += weight * (px * qx + py * qy);
        sine += weight * (px * qy - py * qx);
        drawn_norm += weight * (px * px + py * py);
        seen_norm += weight * (qx * qx + qy * qy);
    }
    let correlation = cosine.hypot(sine) / (drawn_norm.sqrt() * seen_norm.sqrt());
    Likeness { turn: sine.atan2(cosine), correlation }
}

fn mean<const N: usize>(points: &[[f64; N]]) -> [f64; N] {
    std::array::from_fn(|i| points.iter().map(|p| p[i]).sum::<f64>() / points.len() as f64)
}

#[cfg(test)]
mod tests {
    use super::super::fixtures::{cube, square_on};
    use super::*;
    use crate::geometry::cross;

    fn near(a: [f64; 3], b: [f64; 3]) -> bool {
        a.iter().zip(b).all(|(x, y)| (x - y).abs() < 1e-9)
    }

    fn right_handed(frame: &Frame) -> bool {
        near(cross(frame.right, frame.up), frame.toward_camera)
    }

    #[test]
    fn the_mesh_stands_as_the_sketch_does() {
        let (mesh, sketch) = (cube(), square_on(&cube()));
        // A camera that lies on its side.
        let view = Frame { right: [0.0, 1.0, 0.0], up: [-1.0, 0.0, 0.0], toward_camera: [0.0, 0.0, 1.0] };
        let frame = matched(&Matched { view: Some(view), ..sketch.pair(&mesh) });
        assert!(near(frame.right, [1.0, 0.0, 0.0]) && near(frame.up, [0.0, 1.0, 0.0]) && right_handed(&frame));
    }

    #[test]
    fn without_a_view_the_matched_face_is_seen_from_outside() {
        let (mesh, sketch) = (cube(), square_on(&cube()));
        let frame = matched(&Matched { view: None, ..sketch.pair(&mesh) });
        assert!(near(frame.toward_camera, [0.0, 0.0, 1.0]) && near(frame.up, [0.0, 1.0, 0.0]), "{frame:?}");
    }

    #[test]
    fn without_a_view_the_side_that_looks_like_the_sketch_is_seen() {
        let (mesh, sketch) = (cube(), square_on(&cube()));
        // The corners the other way round: the same side from within.
        let mirrored = Matched { view: None, vertices: vec![5, 4, 6, 7], ..sketch.pair(&mesh) };
        let frame = matched(&mirrored);
        assert!(near(frame.toward_camera, [0.0, 0.0, -1.0]) && near(frame.up, [0.0, 1.0, 0.0]), "{frame:?}");
    }

    #[test]
    fn points_that_agree_on_nothing_leave_the_view_alone() {
        let (mesh, sketch) = (cube(), square_on(&cube()));
        let view = Frame::looking_from([1.0, 2.0, 3.0]);
        let one = vec![0; sketch.sketch.mesh().positions().len()];
        assert_eq!(matched(&Matched { view: Some(view), vertices: one, ..sketch.pair(&mesh) }), view);
    }

    #[test]
    fn the_second_view_is_turned_about_the_first_ones_up() {
        let frame = turned(&Frame::looking_from([0.0, -1.0, 0.0]));
        assert!(right_handed(&frame) && near(frame.up, [0.0, 0.0, 1.0]));
        assert!((dot(frame.toward_camera, [0.0, -1.0, 0.0]) - 0.5).abs() < 1e-12);
    }
}
