//! The share of points that lie in the right region.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::Fault;
use crate::mesh::file_mesh::FileMesh;

/// The label of a vertex in no region.
const NONE: i32 = -1;
/// Labels from here on are refused.
const LABELS: i32 = 1000;

/// Regions of a sketch and of a mesh, equal labels corresponding.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields)]
pub struct Labels {
    /// A label from 0 to 999 for every vertex of the sketch; −1 is in no region.
    pub sketch: Vec<i32>,
    /// One for every vertex of the user's mesh file.
    pub mesh: Vec<i32>,
}

/// How many points of a sketch are answered in the right region.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct LabelsEvaluation {
    /// Vertices of the sketch that are in a region.
    pub points: usize,
    /// How many of them are answered by a vertex of that region.
    pub right: usize,
    /// The share of the points that are right; null where there are none.
    #[schema(value_type = Option<f64>)]
    pub share: Option<f64>,
    /// The same by region, in the order of the labels.
    pub regions: Vec<RegionEvaluation>,
    /// In the order of the sketch's vertices, those in a region.
    pub answers: Vec<LabelledAnswer>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct RegionEvaluation {
    pub label: i32,
    pub points: usize,
    pub right: usize,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, ToSchema)]
pub struct LabelledAnswer {
    pub sketch_vertex: u32,
    pub label: i32,
    pub mesh_vertex: u32,
    /// The label of that vertex.
    pub found: i32,
}

impl Labels {
    /// What does not fit shapes of these many vertices.
    pub fn faults(&self, sketch_vertices: usize, mesh_vertices: usize) -> Vec<Fault> {
        let mut faults = Vec::new();
        for (name, labels, vertices) in [("sketch", &self.sketch, sketch_vertices), ("mesh", &self.mesh, mesh_vertices)]
        {
            if labels.len() != vertices {
                let detail = format!("must have a label for each of the {vertices} vertices, has {}", labels.len());
                faults.push(Fault::new(format!("/labels/{name}"), detail));
            }
            if let Some((i, label)) = labels.iter().enumerate().find(|(_, label)| !(NONE..LABELS).contains(*label)) {
                faults.push(Fault::new(format!("/labels/{name}/{i}"), format!("{label} is not −1 to {}", LABELS - 1)));
            }
        }
        faults
    }

    /// What answers are worth, a vertex of the file for every vertex of the sketch, where there are no faults. A vertex
    /// that was merged with others has the label of any of them.
    pub fn evaluation(&self, mesh: &FileMesh, answers: &[u32]) -> LabelsEvaluation {
        let mut merged = vec![Vec::new(); self.mesh.len()];
        for (vertex, &own) in mesh.merged().iter().enumerate() {
            merged[own as usize].push(vertex);
        }
        let labelled = self.sketch.iter().zip(answers).enumerate().filter(|(_, (label, _))| **label != NONE);
        let answers: Vec<LabelledAnswer> = labelled
            .map(|(x, (&label, &answer))| {
                let own = mesh.merged()[answer as usize] as usize;
                let found = if merged[own].iter().any(|&v| self.mesh[v] == label) { label } else { self.mesh[own] };
                LabelledAnswer { sketch_vertex: x as u32, label, mesh_vertex: answer, found }
            })
            .collect();
        let mut regions: Vec<RegionEvaluation> = Vec::new();
        let mut labels: Vec<i32> = answers.iter().map(|answer| answer.label).collect();
        labels.sort_unstable();
        labels.dedup();
        for label in labels {
            let of_label = answers.iter().filter(|answer| answer.label == label);
            let right = of_label.clone().filter(|answer| answer.found == label).count();
            regions.push(RegionEvaluation { label, points: of_label.count(), right });
        }
        let right = regions.iter().map(|region| region.right).sum();
        let share = (!answers.is_empty()).then(|| right as f64 / answers.len() as f64);
        LabelsEvaluation { points: answers.len(), right, share, regions, answers }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::solids::sheet;

    #[test]
    fn points_count_where_their_region_is_found() {
        let mesh: FileMesh = sheet(1, 1).into();
        let labels = Labels { sketch: vec![0, 0, 5, -1, 5], mesh: vec![0, 5, 5, -1] };
        assert!(labels.faults(5, 4).is_empty());
        let found = labels.evaluation(&mesh, &[0, 1, 2, 3, 3]);
        assert_eq!((found.points, found.right, found.share), (4, 2, Some(0.5)));
        let regions: Vec<_> = found.regions.iter().map(|r| (r.label, r.points, r.right)).collect();
        assert_eq!(regions, [(0, 2, 1), (5, 2, 1)]);
        assert_eq!(found.answers[3], LabelledAnswer { sketch_vertex: 4, label: 5, mesh_vertex: 3, found: -1 });
        let none = Labels { sketch: vec![-1], mesh: vec![0; 4] }.evaluation(&mesh, &[0]);
        assert_eq!((none.points, none.share), (0, None));
    }

    #[test]
    fn labels_that_do_not_fit_are_named() {
        let labels = Labels { sketch: vec![0, -2], mesh: vec![1000, 0, 0] };
        let pointers: Vec<String> = labels.faults(3, 3).into_iter().map(|fault| fault.pointer).collect();
        assert_eq!(pointers, ["/labels/sketch", "/labels/sketch/1", "/labels/mesh/0"]);
    }
}
