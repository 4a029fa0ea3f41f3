//! Landmarks as vertices of both shapes.

use std::collections::HashMap;

use super::Fault;
use super::request::Landmark;
use crate::geometry::{length, subtract};
use crate::mesh::figure::Figure;
use crate::mesh::flat::{self, REACH};
use crate::sketch::Sketch;

/// The landmarks as vertices: of the sketch the nearest, of the mesh that of its figure.
///
/// # Errors
/// Every landmark that is off the drawing or not on the figure.
pub(super) fn vertices(
    landmarks: &[Landmark],
    sketch: &Sketch,
    figure: &Figure,
) -> Result<Vec<[usize; 2]>, Vec<Fault>> {
    let mut faults = off_the_drawing(landmarks, sketch);
    let mut vertices = Vec::new();
    for (i, landmark) in landmarks.iter().enumerate() {
        let on_sketch = nearest(sketch, landmark.sketch);
        let on_figure = figure.at(landmark.mesh);
        if on_figure.is_none() {
            let detail = format!("vertex {} is not on the part of the mesh that is matched", landmark.mesh);
            faults.push(Fault::new(format!("/landmarks/{i}/mesh"), detail));
        }
        vertices.extend(on_sketch.zip(on_figure).map(|((x, _), y)| [x, y]));
    }
    if faults.is_empty() {
        faults = contradictions(&vertices, figure);
    }
    if faults.is_empty() { Ok(vertices) } else { Err(faults) }
}

/// The landmarks that are not on the drawing.
pub(super) fn off_the_drawing(landmarks: &[Landmark], sketch: &Sketch) -> Vec<Fault> {
    let reach = flat::reach(sketch.mesh());
    let is_off = |landmark: &Landmark| {
        nearest(sketch, landmark.sketch).is_none_or(|(_, distance)| distance.is_nan() || distance > reach)
    };
    let off = landmarks.iter().enumerate().filter(|(_, landmark)| is_off(landmark));
    off.map(|(i, landmark)| {
        let [x, y] = landmark.sketch;
        Fault::new(format!("/landmarks/{i}/sketch"), format!("({x:?}, {y:?}) is not on the drawing"))
    })
    .collect()
}

/// Every landmark that gives a vertex of the sketch to another place of the mesh than one before it: farther apart than
/// [`REACH`] of the diagonal of the mesh's box.
fn contradictions(vertices: &[[usize; 2]], figure: &Figure) -> Vec<Fault> {
    let positions = figure.mesh.positions();
    let extent = |axis: usize| {
        let (least, most) = positions
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), p| (least.min(p[axis]), most.max(p[axis])));
        most - least
    };
    let reach = REACH * extent(0).hypot(extent(1)).hypot(extent(2));
    let apart = |a: usize, b: usize| length(subtract(positions[a], positions[b])) > reach;
    let mut first = HashMap::new();
    let mut faults = Vec::new();
    for (i, &[x, y]) in vertices.iter().enumerate() {
        let &mut (earlier, vertex) = first.entry(x).or_insert((i, y));
        if apart(vertex, y) {
            let detail = format!(
                "the same place of the drawing is given to vertex {} by landmark {earlier}, far from vertex {}",
                figure.vertices[vertex], figure.vertices[y]
            );
            faults.push(Fault::new(format!("/landmarks/{i}/mesh"), detail));
        }
    }
    faults
}

/// The vertex of the sketch nearest to a point in the coordinates of the upload, and its distance within the sketch's
/// mesh.
fn nearest(sketch: &Sketch, point: [f64; 2]) -> Option<(usize, f64)> {
    flat::nearest(sketch.mesh(), sketch.to_internal(point))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TriangleMesh;
    use crate::sketch::YAxis;

    /// A unit square drawn with y downwards, one corner at the origin.
    fn square() -> Sketch {
        let positions = vec![[0., 0., 0.], [1., 0., 0.], [1., -1., 0.], [0., -1., 0.]];
        Sketch::new(TriangleMesh::new(positions, vec![[0, 2, 1], [0, 3, 2]]).unwrap(), YAxis::Down).unwrap()
    }

    /// A triangle, and a vertex 0 that belongs to none.
    fn triangle() -> Figure {
        let positions = vec![[9., 9., 9.], [0., 0., 0.], [1., 0., 0.], [0., 1., 0.]];
        Figure::largest(&TriangleMesh::new(positions, vec![[1, 2, 3]]).unwrap().into())
    }

    fn placed(landmarks: &[([f64; 2], u32)]) -> Result<Vec<[usize; 2]>, Vec<String>> {
        let landmarks: Vec<Landmark> = landmarks.iter().map(|&(sketch, mesh)| Landmark { sketch, mesh }).collect();
        let faults = |faults: Vec<Fault>| faults.into_iter().map(|fault| fault.pointer).collect();
        vertices(&landmarks, &square(), &triangle()).map_err(faults)
    }

    #[test]
    fn landmarks_become_the_nearest_vertices() {
        assert_eq!(placed(&[([0.9, 0.9], 1), ([-0.01, 0.02], 3)]), Ok(vec![[2, 0], [0, 2]]));
    }

    #[test]
    fn a_point_inside_a_large_triangle_is_on_the_drawing() {
        assert_eq!(placed(&[([0.5, 0.4], 2)]).map(|vertices| vertices.len()), Ok(1));
    }

    #[test]
    fn a_place_of_the_drawing_has_one_place_of_the_mesh() {
        assert_eq!(placed(&[([0., 0.], 1), ([1., 1.], 2), ([0.01, 0.], 1)]).map(|vertices| vertices.len()), Ok(3));
        let faults = placed(&[([0., 0.], 1), ([1., 1.], 2), ([0., 0.], 3), ([1., 1.], 1)]).unwrap_err();
        assert_eq!(faults, ["/landmarks/2/mesh", "/landmarks/3/mesh"]);
    }

    #[test]
    fn everything_off_the_shapes_is_named() {
        let faults = placed(&[([0., 0.], 1), ([40., 0.], 2), ([f64::NAN, 0.], 0)]).unwrap_err();
        assert_eq!(faults, ["/landmarks/1/sketch", "/landmarks/2/sketch", "/landmarks/2/mesh"]);
    }
}
