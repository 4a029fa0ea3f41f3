//! The faces of a file cut into triangles.

use super::formats::Polygons;
use super::polygon;
use super::refusal::{Faults, Place};
use super::soundness::{self, MOST_CORNERS};

/// The triangles that the faces of a file are cut into.
#[derive(Default)]
pub(super) struct Cut {
    pub triangles: Vec<[u32; 3]>,
    /// Per triangle the face it is part of, ascending.
    pub faces: Vec<usize>,
    /// The faces of fewer than three corners.
    pub too_few: Vec<usize>,
    /// The faces of more than three corners of which no three are different.
    pub collapsed: Vec<usize>,
    /// The faces that cross themselves or have no area, and so are not covered by their triangles.
    pub crossing: Vec<usize>,
}

impl Cut {
    /// The triangles of all faces. A fault is a face that names a vertex out of range or without sound coordinates.
    pub fn of(polygons: &Polygons, faults: &mut Faults) -> Cut {
        let mut cut = Cut::default();
        let mut looks = polygon::LOOKS;
        let mut nowhere = vec![false; polygons.positions.len()];
        for (f, corners) in polygons.faces().enumerate() {
            let place = || polygons.face_place(f);
            if corners.len() < 3 {
                cut.too_few.push(f);
            } else if corners.len() > MOST_CORNERS {
                faults.push(place(), format!("a face of more than {MOST_CORNERS} corners"));
            } else if let Some(polygon) = existing(corners, polygons, place(), faults) {
                let unsound = |v: &&u32| !soundness::is_sound(polygons.positions[**v as usize]);
                let mut unsound = polygon.iter().filter(unsound).peekable();
                let is_placed = unsound.peek().is_none();
                unsound.for_each(|&v| nowhere[v as usize] = true);
                if is_placed {
                    cut.push(f, polygon, polygons, &mut looks);
                }
            }
        }
        for v in (0..nowhere.len()).filter(|&v| nowhere[v]) {
            soundness::coordinates_of(polygons.positions[v], polygons.vertex_place(v), faults);
        }
        cut
    }

    fn push(&mut self, face: usize, mut polygon: Vec<u32>, polygons: &Polygons, looks: &mut usize) {
        if polygon.len() > 3 {
            polygon.dedup();
            while polygon.len() > 1 && polygon.first() == polygon.last() {
                polygon.pop();
            }
        }
        if polygon.len() < 3 {
            return self.collapsed.push(face);
        }
        let polygon::Cut { triangles, clean } = polygon::cut(&polygon, &polygons.positions, looks);
        if !clean {
            self.crossing.push(face);
        }
        self.faces.extend(std::iter::repeat_n(face, triangles.len()));
        self.triangles.extend(triangles);
    }
}

/// The corners of a face as vertices, where all exist.
fn existing(corners: &[i64], polygons: &Polygons, place: Place, faults: &mut Faults) -> Option<Vec<u32>> {
    let vertices = polygons.positions.len();
    match corners.iter().find(|&&v| !usize::try_from(v).is_ok_and(|v| v < vertices)) {
        None => Some(corners.iter().map(|&v| v as u32).collect()),
        Some(&v) => {
            faults.push(place, soundness::no_such_vertex(v, vertices, polygons.first_vertex));
            None
        }
    }
}
