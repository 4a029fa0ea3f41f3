//! How far an answer is from the truth: geodesic errors as a share of the size of the mesh [KLF11], and the share of points
//! that lie in the right region.

pub mod labels;
pub mod measures;
pub mod pairs;
pub mod regions;
pub mod truth;

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use crate::mesh::file_mesh::FileMesh;
use labels::{Labels, LabelsEvaluation};
use pairs::PairsEvaluation;
use truth::Truth;

/// What is known of how a sketch and a mesh correspond.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Known {
    /// Points of the sketch and their vertices of the mesh.
    Pairs(Truth),
    /// Regions of both shapes.
    Labels(Labels),
}

impl Known {
    /// What does not fit a sketch with vertices at these places and a mesh of so many, or is more than can be judged.
    pub fn faults(&self, at: &[[f64; 2]], mesh_vertices: usize) -> Vec<Fault> {
        match self {
            Known::Pairs(truth) => {
                let faults = truth.faults(mesh_vertices);
                if faults.is_empty() { truth.misplaced(at).into_iter().collect() } else { faults }
            }
            Known::Labels(labels) => labels.faults(at.len(), mesh_vertices),
        }
    }

    /// Numbers that are kept at most while an answer with these many vertices is judged on a mesh of so many.
    pub fn numbers(&self, answers: usize, mesh_vertices: usize) -> usize {
        match self {
            Known::Pairs(truth) => truth.distances(answers, mesh_vertices),
            Known::Labels(_) => 0,
        }
    }

    /// What an answer is worth, where there are no faults: `at` are the places of the sketch's vertices in its own
    /// coordinates, `to` for each a vertex of the mesh's file.
    pub fn evaluation(&self, mesh: &FileMesh, at: &[[f64; 2]], to: &[u32]) -> Evaluation {
        match self {
            Known::Pairs(truth) => Evaluation::Pairs(truth.evaluation(mesh, &truth.answers(at, to))),
            Known::Labels(labels) => Evaluation::Labels(labels.evaluation(mesh, to)),
        }
    }
}

/// What an answer is worth, by what is known.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Evaluation {
    Pairs(PairsEvaluation),
    Labels(LabelsEvaluation),
}

/// One thing wrong with what is said to be known.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    /// JSON pointer into it.
    pub pointer: String,
    pub detail: String,
}

impl Fault {
    fn new(pointer: impl Into<String>, detail: impl Into<String>) -> Fault {
        Fault { pointer: pointer.into(), detail: detail.into() }
    }
}
