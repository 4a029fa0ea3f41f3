//! Taken by points.

use super::request::{Moved, Values};
use crate::correspondence::inverse;
use crate::mesh::file_mesh::FileMesh;
use crate::numerics::Unwatched;
use crate::regions::Regions;

/// What is given at the vertices that these places name.
pub fn taken(given: &Values<'_>, from: &[Option<usize>]) -> Moved {
    let from = from.iter().copied();
    match given {
        Values::Function(values) => Moved::Function { values: from.map(|v| Some(values[v?])).collect() },
        Values::Labels(values) => {
            Moved::Labels { values: from.map(|v| v.map_or(Regions::NONE, |v| values[v])).collect() }
        }
        Values::Colours(values) => Moved::Colours { values: from.map(|v| Some(values[v?])).collect() },
    }
}

/// For every vertex of the file the nearest of the answers, counted from 0 again after every m.
pub fn inverse(mesh: &FileMesh, answers: &[u32], m: usize) -> Vec<Option<usize>> {
    // An answer on no triangle answers for nothing.
    let on_mesh = answers.iter().enumerate();
    let (places, sources): (Vec<usize>, Vec<u32>) =
        on_mesh.filter_map(|(i, &answer)| Some((i % m, mesh.sound_vertices(answer).next()?))).unzip();
    let found = inverse::of_points(mesh.sound(), &sources, &Unwatched).expect("nobody says stop");
    let of_file = 0..mesh.positions().len() as u32;
    of_file.map(|v| Some(places[found[mesh.sound_vertices(v).next()? as usize]?])).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::solids::sheet;

    #[test]
    fn what_is_given_stays_what_it_is() {
        let from = [Some(1), None, Some(0)];
        let function = taken(&Values::Function(&[0.5, 2.0]), &from);
        assert_eq!(function, Moved::Function { values: vec![Some(2.0), None, Some(0.5)] });
        let labels = taken(&Values::Labels(&[7, 3]), &from);
        assert_eq!(labels, Moved::Labels { values: vec![3, -1, 7] });
    }

    #[test]
    fn the_nearest_answer_counts_and_its_twin_for_the_same_vertex() {
        let mesh = FileMesh::from(sheet(10, 10));
        // Two vertices of the sketch at one end of a side, their twins at the other.
        let found = inverse(&mesh, &[0, 1, 10, 9], 2);
        assert_eq!([0, 1, 9, 10, 60].map(|v: usize| found[v]), [Some(0), Some(1), Some(1), Some(0), None]);
    }
}
