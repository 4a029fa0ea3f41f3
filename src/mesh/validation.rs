//! From a user's file to a proven mesh: what can be mended safely is mended and told, the rest is refused with every
//! reason.

use super::TriangleMesh;
use super::connectivity::{self, Extent};
use super::edges::Edges;
use super::formats::{self, Format, Limits, Polygons};
use super::refusal::{Faults, Place, Refusal, Warning, WarningCode};
use super::{polygon, soundness, winding};

/// Share of the whole area below which a component is a speck.
const SPECK: f64 = 1e-3;

/// A file's mesh, and what is to be known of it.
#[derive(Clone, Debug, PartialEq)]
pub struct Imported {
    pub mesh: TriangleMesh,
    pub warnings: Vec<Warning>,
}

/// The mesh of a file, its vertices those of the file in their order.
///
/// Mended with a warning: repeated faces, inconsistent winding, vertices of no face. Refused: what exceeds the limits,
/// what cannot be read, and what is no valid mesh even then, every reason with its vertex, face and line.
pub fn import(bytes: &[u8], format: Format, limits: &Limits) -> Result<Imported, Refusal> {
    limits.admit_bytes(bytes.len())?;
    let polygons = formats::read(bytes, format, limits)?;
    let mut faults = Faults::default();
    let mut warnings = file_warnings(&polygons);
    let cut = Cut::of(&polygons, &mut faults);
    let (cut, duplicates) = cut.without_duplicates();
    warnings.extend(duplicates.map(|faces| {
        let detail = format!("{} faces repeat another face and are dropped", faces.len());
        Warning::new(WarningCode::DuplicateFaces, detail, faces.iter().map(|&f| polygons.face_place(f)))
    }));
    let (cut, flipped) = cut.proven(&polygons, &mut faults);
    faults.into_result()?;
    warnings.extend(flipped.map(|faces| {
        let detail = format!("{} faces are turned over to agree with their neighbours", faces.len());
        Warning::new(WarningCode::FlippedWinding, detail, faces.iter().map(|&f| polygons.face_place(f)))
    }));
    warnings.extend(unreferenced(&polygons, &cut.triangles));
    let mesh = TriangleMesh::new(polygons.positions, cut.triangles)?;
    warnings.extend(component_warnings(&mesh));
    Ok(Imported { mesh, warnings })
}

/// The triangles that the polygons of a file are cut into.
struct Cut {
    triangles: Vec<[u32; 3]>,
    /// Per triangle the face it is part of.
    faces: Vec<usize>,
    /// Whether no face had to be left out.
    complete: bool,
}

impl Cut {
    fn of(polygons: &Polygons, faults: &mut Faults) -> Cut {
        for (count, unit) in [(polygons.positions.len(), "vertices"), (polygons.faces().len(), "faces")] {
            if count == 0 {
                faults.push(Place::file(), format!("there are no {unit}"));
            }
        }
        let mut cut = Cut { triangles: Vec::new(), faces: Vec::new(), complete: true };
        for (f, corners) in polygons.faces().enumerate() {
            match cut_face(corners, polygons, &polygons.face_place(f), faults) {
                Some(triangles) => {
                    cut.faces.extend(std::iter::repeat_n(f, triangles.len()));
                    cut.triangles.extend(triangles);
                }
                None => cut.complete = false,
            }
        }
        cut
    }

    /// The same without triangles that occurred before, and the faces that lost some.
    fn without_duplicates(self) -> (Cut, Option<Vec<usize>>) {
        let firsts = soundness::firsts(&self.triangles);
        let (mut kept, mut dropped) = (Cut { triangles: Vec::new(), faces: Vec::new(), ..self }, Vec::new());
        for (t, &first) in firsts.iter().enumerate() {
            if t == first {
                kept.triangles.push(self.triangles[t]);
                kept.faces.push(self.faces[t]);
            } else {
                dropped.push(self.faces[t]);
            }
        }
        (kept, distinct(dropped))
    }

    /// The same wound consistently, and the faces turned over for it. All that is wrong is a fault.
    fn proven(mut self, polygons: &Polygons, faults: &mut Faults) -> (Cut, Option<Vec<usize>>) {
        let mut found = Faults::default();
        let positions = &polygons.positions;
        soundness::coordinates(positions, &mut found);
        let edges = Edges::of(&self.triangles);
        soundness::areas(positions, &self.triangles, &mut found);
        soundness::crowded_edges(&edges, &mut found);
        // A face left out would tear the fans around its vertices.
        if self.complete {
            soundness::fans(positions.len(), &self.triangles, &edges, &mut found);
        }
        let flipped = winding::inconsistent(positions, &self.triangles, &edges, &mut found);
        for triangle in self.triangles.iter_mut().zip(&flipped).filter_map(|(t, &flip)| flip.then_some(t)) {
            triangle.swap(1, 2);
        }
        for fault in found.listed {
            faults.push(self.in_file(fault.place, polygons), fault.detail);
        }
        faults.unlisted += found.unlisted;
        let faces = (0..flipped.len()).filter(|&t| flipped[t]).map(|t| self.faces[t]).collect();
        (self, distinct(faces))
    }

    /// A place in triangles as one in the faces and lines of the file.
    fn in_file(&self, place: Place, polygons: &Polygons) -> Place {
        let at = match (place.face, place.vertices.as_slice()) {
            (Some(t), _) => polygons.face_place(self.faces[t as usize]),
            (None, &[v]) => polygons.vertex_place(v as usize),
            _ => Place::file(),
        };
        Place { vertices: place.vertices, ..at }
    }
}

/// The ascending numbers once each; none for an empty list.
fn distinct(mut numbers: Vec<usize>) -> Option<Vec<usize>> {
    numbers.dedup();
    (!numbers.is_empty()).then_some(numbers)
}

/// The triangles of one face; none where it is at fault.
fn cut_face(corners: &[i64], polygons: &Polygons, place: &Place, faults: &mut Faults) -> Option<Vec<[u32; 3]>> {
    let positions = &polygons.positions;
    if !soundness::corners(corners, positions.len(), place, faults) {
        return None;
    }
    let polygon: Vec<u32> = corners.iter().map(|&v| v as u32).collect();
    // A polygon cannot be cut where a corner is nowhere; the corner is a fault of its own.
    let cuttable = polygon.len() == 3 || polygon.iter().all(|&v| soundness::is_sound(positions[v as usize]));
    if !cuttable {
        return None;
    }
    let triangles = polygon::triangles(&polygon, positions);
    if triangles.is_none() {
        let n = polygon.len();
        faults.push(place.clone(), format!("its {n} corners make no polygon: it crosses itself or has no area"));
    }
    triangles
}

fn file_warnings(polygons: &Polygons) -> Vec<Warning> {
    let mut warnings = Vec::new();
    if polygons.ignored > 0 {
        let detail = format!("{} elements of the file are no faces and are left out", polygons.ignored);
        warnings.push(Warning::new(WarningCode::IgnoredElements, detail, []));
    }
    if !polygons.merged.is_empty() {
        let detail =
            format!("{} vertices stand where an earlier one does, which takes their place", polygons.merged.len());
        let places = polygons.merged.iter().map(|&v| polygons.vertex_place(v as usize));
        warnings.push(Warning::new(WarningCode::MergedVertices, detail, places));
    }
    warnings
}

/// The warning of vertices that no face ever named.
fn unreferenced(polygons: &Polygons, triangles: &[[u32; 3]]) -> Option<Warning> {
    let mut accounted = vec![false; polygons.positions.len()];
    for &v in triangles.as_flattened().iter().chain(&polygons.merged) {
        accounted[v as usize] = true;
    }
    let vertices: Vec<usize> = (0..accounted.len()).filter(|&v| !accounted[v]).collect();
    let detail = format!("{} vertices belong to no face and are not matched", vertices.len());
    let places = vertices.iter().map(|&v| polygons.vertex_place(v));
    (!vertices.is_empty()).then(|| Warning::new(WarningCode::UnreferencedVertices, detail, places))
}

fn component_warnings(mesh: &TriangleMesh) -> Vec<Warning> {
    let components = connectivity::components(mesh).list;
    if components.len() < 2 {
        return Vec::new();
    }
    let area = mesh.area();
    let place = |component: &Extent| Place::vertex(component.first_vertex as usize);
    let largest = components.iter().map(|c| c.area).fold(0.0, f64::max);
    let detail = format!(
        "the mesh has {} components: only the largest, {:.1} % of the area, is matched",
        components.len(),
        100.0 * largest / area
    );
    let mut warnings = vec![Warning::new(WarningCode::SeveralComponents, detail, components.iter().map(place))];
    let specks: Vec<&Extent> = components.iter().filter(|c| c.area < SPECK * area).collect();
    if !specks.is_empty() {
        let triangles: usize = specks.iter().map(|c| c.triangles).sum();
        let detail = format!("{} components of {triangles} triangles are specks", specks.len());
        warnings.push(Warning::new(WarningCode::IsolatedSpecks, detail, specks.into_iter().map(place)));
    }
    warnings
}
