//! Handles and their maps in the plane of the sketch's mesh, and what is wrong with them.

use super::request::{CORNERS, HandleRequest, MAX_FRAMES, MAX_HANDLES, MAX_WEIGHTS, MapRequest, PoseRequest};
use crate::deformation::handles::{Handle, Held, Misplaced};
use crate::pipeline::Fault;
use crate::sketch::{Sketch, YAxis};

/// How far a map may take the drawing, in diagonals of its box.
const FARTHEST: f64 = 1e3;
/// A map whose determinant is a smaller share of the square of its size takes the plane to a line.
const LEAST_DETERMINANT: f64 = 1e-9;

/// p ↦ A p + b by rows (A | b).
pub(super) type Map = [[f64; 3]; 2];

const STAY: Map = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

/// What a pose is to be, read: handles that hold the drawing, and a map for every weight in each frame.
pub(super) struct Moves {
    pub held: Held,
    pub frames: Vec<Vec<Map>>,
}

/// What is wrong with a request for a sketch, as far as the sketch tells.
pub fn faults(request: &PoseRequest, sketch: &Sketch) -> Vec<Fault> {
    match moves(request, sketch) {
        Ok(_) => Vec::new(),
        Err(faults) => faults,
    }
}

/// The handles and maps of a request; none where it asks for the pose of the drawing.
///
/// # Errors
/// Every fault, with its place.
pub(super) fn moves(request: &PoseRequest, sketch: &Sketch) -> Result<Option<Moves>, Vec<Fault>> {
    let (handles, frames) = match (&request.handles, &request.frames, &request.sketch) {
        (Some(handles), Some(frames), None) => (handles, frames),
        (None, None, Some(_)) => return Ok(None),
        (None, None, None) => return Err(vec![fault("", "a pose has `handles` and `frames`, or `sketch`")]),
        (_, _, Some(_)) => return Err(vec![fault("/sketch", "a pose has `handles` and `frames`, or `sketch`")]),
        (None, Some(_), None) => return Err(vec![fault("/handles", "frames move handles, and there are none")]),
        (Some(_), None, None) => return Err(vec![fault("/frames", "handles need at least one frame to move in")]),
    };
    let mut faults = Vec::new();
    let mut count = |pointer: &str, value: usize, least: usize, most: usize| {
        if !(least..=most).contains(&value) {
            faults.push(fault(pointer, format!("must be {least} to {most}, is {value}")));
        }
    };
    count("/handles", handles.len(), 1, MAX_HANDLES);
    count("/frames", frames.len(), 1, MAX_FRAMES);
    for (i, handle) in handles.iter().enumerate() {
        if let HandleRequest::Cage { points } = handle {
            count(&format!("/handles/{i}/points"), points.len(), *CORNERS.start(), *CORNERS.end());
        }
    }
    let read: Vec<Handle> = handles.iter().map(|handle| placed(handle, sketch)).collect();
    let weights: usize = read.iter().map(Handle::functions).sum();
    if weights > MAX_WEIGHTS {
        faults.push(fault("/handles", format!("corners of cages counted, at most {MAX_WEIGHTS} can be had")));
    }
    if !faults.is_empty() {
        return Err(faults);
    }
    let size = Size::of(sketch);
    let mut maps = Vec::new();
    for (f, frame) in frames.iter().enumerate() {
        if frame.len() != handles.len() {
            let detail = format!("there are {} handles and {} maps here: one for each", handles.len(), frame.len());
            faults.push(fault(format!("/frames/{f}"), detail));
            continue;
        }
        let mut of_frame = Vec::new();
        for (h, (map, handle)) in frame.iter().zip(&read).enumerate() {
            match mapped(map, handle, sketch, &size) {
                Ok(own) => of_frame.extend(own),
                Err((member, detail)) => faults.push(fault(format!("/frames/{f}/{h}{member}"), detail)),
            }
        }
        maps.push(of_frame);
    }
    let held = Held::new(sketch.mesh(), &read).map_err(|misplaced| {
        let pointed = misplaced.into_iter().map(|Misplaced { handle, member, detail }| {
            let slash = if member.is_empty() { "" } else { "/" };
            fault(format!("/handles/{handle}{slash}{member}"), detail)
        });
        pointed.collect::<Vec<_>>()
    });
    match held {
        Ok(held) if faults.is_empty() => Ok(Some(Moves { held, frames: maps })),
        held => Err(held.err().into_iter().flatten().chain(faults).collect()),
    }
}

fn fault(pointer: impl Into<String>, detail: impl Into<String>) -> Fault {
    Fault { pointer: pointer.into(), detail: detail.into() }
}

/// A handle in the plane of the sketch's mesh.
fn placed(handle: &HandleRequest, sketch: &Sketch) -> Handle {
    let internal = |p: [f64; 2]| sketch.to_internal(p);
    match handle {
        HandleRequest::Point { at } => Handle::Point(internal(*at)),
        HandleRequest::Bone { from, to } => Handle::Bone([internal(*from), internal(*to)]),
        HandleRequest::Cage { points } => Handle::Cage(points.iter().map(|&p| internal(p)).collect()),
    }
}

/// The maps of a handle's weights; or which member of the map is wrong, and why.
fn mapped(map: &MapRequest, handle: &Handle, sketch: &Sketch, size: &Size) -> Result<Vec<Map>, (&'static str, String)> {
    let internal = |p: [f64; 2]| sketch.to_internal(p);
    let (member, maps) = match (map, handle) {
        (MapRequest::Stay {}, _) => ("", vec![STAY; handle.functions()]),
        (MapRequest::Translation { by }, _) => ("/by", vec![translation(internal(*by)); handle.functions()]),
        (MapRequest::Rotation { degrees, about, by }, _) => {
            let about = about.map_or_else(|| pivot(handle), internal);
            ("", vec![rotation(*degrees, about, internal(*by)); handle.functions()])
        }
        (MapRequest::Affine { matrix }, _) => {
            let [[a, b, _], [d, e, _]] = matrix;
            let (determinant, squares) = (a * e - b * d, a * a + b * b + d * d + e * e);
            if determinant.is_nan() || determinant <= LEAST_DETERMINANT * squares {
                let what =
                    if determinant < -LEAST_DETERMINANT * squares { "turns the plane over" } else { "is singular" };
                return Err(("/matrix", format!("the map {what}: its determinant is {determinant:?}")));
            }
            ("/matrix", vec![flipped(*matrix, sketch.y_axis()); handle.functions()])
        }
        (MapRequest::Corners { points }, Handle::Cage(corners)) => {
            if points.len() != corners.len() {
                let detail = format!("the cage has {} corners, here are {}", corners.len(), points.len());
                return Err(("/points", detail));
            }
            let moved = points.iter().map(|&p| internal(p)).zip(corners);
            ("/points", moved.map(|(to, from)| translation([to[0] - from[0], to[1] - from[1]])).collect())
        }
        (MapRequest::Corners { .. }, _) => return Err(("/type", "only a cage has corners".to_owned())),
    };
    match maps.iter().all(|map| size.holds(map)) {
        true => Ok(maps),
        false => Err((member, format!("it goes farther than {FARTHEST:?} times the size of the sketch"))),
    }
}

fn translation([x, y]: [f64; 2]) -> Map {
    [[1.0, 0.0, x], [0.0, 1.0, y]]
}

fn rotation(degrees: f64, [x, y]: [f64; 2], by: [f64; 2]) -> Map {
    let (sin, cos) = degrees.to_radians().sin_cos();
    // Of the point the map takes to `by` farther than it turns about.
    [[cos, -sin, x - cos * x + sin * y + by[0]], [sin, cos, y - sin * x - cos * y + by[1]]]
}

/// A map of the upload's coordinates as one of the mesh's, or the reverse.
fn flipped([[a, b, c], [d, e, f]]: Map, y_axis: YAxis) -> Map {
    match y_axis {
        YAxis::Up => [[a, b, c], [d, e, f]],
        YAxis::Down => [[a, -b, c], [-d, e, -f]],
    }
}

/// What a handle turns about where nothing else is said.
fn pivot(handle: &Handle) -> [f64; 2] {
    match handle {
        Handle::Point(at) => *at,
        Handle::Bone([from, _]) => *from,
        Handle::Cage(points) => {
            [0, 1].map(|axis| points.iter().map(|p| p[axis]).sum::<f64>() / points.len().max(1) as f64)
        }
    }
}

/// Where a map takes a point.
pub(super) fn applied([[a, b, c], [d, e, f]]: &Map, [x, y]: [f64; 2]) -> [f64; 2] {
    [a * x + b * y + c, d * x + e * y + f]
}

/// The box of a sketch.
struct Size {
    low: [f64; 2],
    high: [f64; 2],
}

impl Size {
    fn of(sketch: &Sketch) -> Size {
        let bound = |axis: usize, pick: fn(f64, f64) -> f64, start: f64| {
            sketch.mesh().positions().iter().map(|p| p[axis]).fold(start, pick)
        };
        Size {
            low: [0, 1].map(|axis| bound(axis, f64::min, f64::INFINITY)),
            high: [0, 1].map(|axis| bound(axis, f64::max, f64::NEG_INFINITY)),
        }
    }

    /// Whether a map takes no corner of the box too far.
    fn holds(&self, map: &Map) -> bool {
        let ([x, y], [u, v]) = (self.low, self.high);
        let most = FARTHEST * (u - x).hypot(v - y);
        [[x, y], [u, y], [u, v], [x, v]].into_iter().all(|corner| {
            let [p, q] = applied(map, corner);
            (p - x).hypot(q - y) <= most
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TriangleMesh;
    use crate::mesh::solids::sheet;
    use serde_json::{Value, json};

    /// A sheet of 1.41 by 0.71, its corner at the origin, drawn with y as told.
    fn sketch(y_axis: YAxis) -> Sketch {
        let mesh = sheet(8, 4);
        let flip = |[x, y, z]: [f64; 3]| {
            if y_axis == YAxis::Down { [x, y - std::f64::consts::FRAC_1_SQRT_2, z] } else { [x, y, z] }
        };
        let positions = mesh.positions().iter().map(|&p| flip(p)).collect();
        Sketch::new(TriangleMesh::new(positions, mesh.triangles().to_vec()).unwrap(), y_axis).unwrap()
    }

    fn request(handles: Value, frames: Value) -> PoseRequest {
        serde_json::from_value(json!({"match": "m", "handles": handles, "frames": frames})).unwrap()
    }

    fn pointers(request: &PoseRequest) -> Vec<String> {
        faults(request, &sketch(YAxis::Up)).into_iter().map(|fault| fault.pointer).collect()
    }

    #[test]
    fn maps_are_those_of_the_upload() {
        let handles = json!([{"type": "point", "at": [0.2, 0.1]}]);
        for (map, taken) in [
            (json!({"type": "stay"}), [0.2, 0.1]),
            (json!({"type": "translation", "by": [0.1, -0.3]}), [0.3, -0.2]),
            (json!({"type": "rotation", "degrees": 90, "by": [1, 0]}), [1.2, 0.1]),
            (json!({"type": "affine", "matrix": [[2, 1, 0], [0, 1, 5]]}), [0.5, 5.1]),
        ] {
            for y_axis in [YAxis::Up, YAxis::Down] {
                let sketch = sketch(y_axis);
                let moves = moves(&request(handles.clone(), json!([[map]])), &sketch).unwrap().unwrap();
                let [x, y] = sketch.to_internal(applied(&moves.frames[0][0], sketch.to_internal([0.2, 0.1])));
                assert!((x - taken[0]).hypot(y - taken[1]) < 1e-12, "{map}: {x} {y}");
            }
        }
    }

    #[test]
    fn a_turn_is_counter_clockwise_as_it_is_seen() {
        let handles = json!([{"type": "point", "at": [0.2, 0.1]}]);
        let turn = json!([[{"type": "rotation", "degrees": 90, "about": [0, 0]}]]);
        for (y_axis, to) in [(YAxis::Up, [0.0, 1.0]), (YAxis::Down, [0.0, -1.0])] {
            let sketch = sketch(y_axis);
            let moves = moves(&request(handles.clone(), turn.clone()), &sketch).unwrap().unwrap();
            let [x, y] = sketch.to_internal(applied(&moves.frames[0][0], sketch.to_internal([1.0, 0.0])));
            assert!((x - to[0]).hypot(y - to[1]) < 1e-12);
        }
    }

    #[test]
    fn corners_of_a_cage_have_maps_of_their_own() {
        let cage = json!([{"type": "cage", "points": [[-1, -1], [2, -1], [2, 2]]}]);
        let corners = json!([[{"type": "corners", "points": [[-1, -1], [3, -1], [2, 4]]}]]);
        let moves = moves(&request(cage, corners), &sketch(YAxis::Up)).unwrap().unwrap();
        assert_eq!(moves.frames, [[translation([0., 0.]), translation([1., 0.]), translation([0., 2.])]]);
    }

    #[test]
    fn every_fault_has_its_place() {
        let (point, stay) = (json!({"type": "point", "at": [0.2, 0.1]}), json!({"type": "stay"}));
        let affine = |matrix: Value| json!([[{"type": "affine", "matrix": matrix}]]);
        let one = |frames: Value| pointers(&request(json!([point]), frames));
        assert_eq!(one(json!([[stay]])), [""; 0]);
        assert_eq!(one(affine(json!([[1, 2, 0], [2, 4, 0]]))), ["/frames/0/0/matrix"]);
        assert_eq!(one(affine(json!([[-1, 0, 0], [0, 1, 0]]))), ["/frames/0/0/matrix"]);
        assert_eq!(one(affine(json!([[1e9, 0, 0], [0, 1e9, 0]]))), ["/frames/0/0/matrix"]);
        assert_eq!(one(json!([[stay], [stay, stay]])), ["/frames/1"]);
        assert_eq!(one(json!([[{"type": "translation", "by": [1e9, 0]}]])), ["/frames/0/0/by"]);
        assert_eq!(one(json!([[{"type": "corners", "points": [[0, 0]]}]])), ["/frames/0/0/type"]);
        assert_eq!(one(json!([])), ["/frames"]);
        assert_eq!(pointers(&request(json!([]), json!([[]]))), ["/handles"]);
        assert_eq!(one(Value::Array(vec![json!([stay]); MAX_FRAMES + 1])), ["/frames"]);
        let far = json!([{"type": "point", "at": [9, 9]}, point, point]);
        assert_eq!(pointers(&request(far, json!([[stay, stay, stay]]))), ["/handles/0/at"]);
        let twice = json!([point, {"type": "bone", "from": [0.2, 0.1], "to": [1, 0.5]}]);
        assert_eq!(pointers(&request(twice, json!([[stay, stay]]))), ["/handles/1"]);
        let crossed = json!([{"type": "cage", "points": [[0, 0], [1, 1], [1, 0], [0, 1]]}]);
        assert_eq!(pointers(&request(crossed, json!([[stay]]))), ["/handles/0/points/0"]);
        let neither = PoseRequest { matching: "m".to_owned(), ..PoseRequest::default() };
        assert_eq!(pointers(&neither), [""]);
        let both = PoseRequest { sketch: Some("s".to_owned()), ..request(json!([point]), json!([[stay]])) };
        assert_eq!(pointers(&both), ["/sketch"]);
    }
}
