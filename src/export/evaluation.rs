//! What an answer is worth, as a table and as a plot.

use std::fmt::Write;

use bytes::Bytes;

use crate::evaluation::Evaluation;
use crate::evaluation::measures::{Measures, thresholds};
use crate::evaluation::pairs::PairsEvaluation;
use crate::picture::plot::{Axis, Curve, Plot};

/// A table (RFC 4180) with a header, a row per point; an empty field where an error is not known or a point cannot be
/// reached.
pub fn csv(evaluation: &Evaluation) -> Bytes {
    let mut table = String::new();
    // Writing to a string cannot fail.
    match evaluation {
        Evaluation::Pairs(pairs) => {
            table.push_str("point,x,y,mesh_vertex,coherent,pointwise\r\n");
            for (i, row) in pairs.points.iter().enumerate() {
                let [x, y] = row.point;
                let [coherent, pointwise] = [row.coherent, row.pointwise].map(number);
                let _ = write!(table, "{i},{x},{y},{},{coherent},{pointwise}\r\n", row.mesh_vertex);
            }
        }
        Evaluation::Labels(labels) => {
            table.push_str("sketch_vertex,label,mesh_vertex,found\r\n");
            for row in &labels.answers {
                let _ = write!(table, "{},{},{},{}\r\n", row.sketch_vertex, row.label, row.mesh_vertex, row.found);
            }
        }
    }
    table.into()
}

/// A number in a table; nothing where there is none.
pub fn number(value: f64) -> String {
    if value.is_finite() { value.to_string() } else { String::new() }
}

/// The plot of curves of errors: the share of points up to each error.
pub fn plot(title: impl Into<String>, curves: Vec<Curve>) -> Plot {
    let thresholds = thresholds();
    Plot {
        title: title.into(),
        across: Axis { name: "geodesic error".to_owned(), range: [0.0, thresholds[thresholds.len() - 1]] },
        up: Axis { name: "share of points".to_owned(), range: [0.0, 1.0] },
        curves,
    }
}

/// The curve of errors with these measures, named with their mean.
pub fn curve(name: &str, colour: usize, measures: &Measures) -> Curve {
    let points = thresholds().into_iter().zip(&measures.curve).map(|(t, &share)| [t, share]).collect();
    Curve { name: format!("{name} {:.3}", measures.mean), colour, points }
}

/// The plot of one evaluation: its coherent and its pointwise errors, and those of every variant.
pub fn plot_of(pairs: &PairsEvaluation) -> Plot {
    let mut curves = vec![curve("coherent", 0, &pairs.coherent), curve("pointwise", 1, &pairs.pointwise)];
    curves.extend(pairs.variants.iter().enumerate().map(|(i, (name, measures))| curve(name, 2 + i, measures)));
    plot("errors and their means", curves)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evaluation::Known;
    use crate::mesh::file_mesh::FileMesh;
    use crate::mesh::solids::sheet;

    fn evaluation(known: &str) -> Evaluation {
        let known: Known = serde_json::from_str(known).unwrap();
        let mesh = FileMesh::from(sheet(1, 1));
        known.evaluation(&mesh, &[[0.0, 0.0], [2.0, 1.0]], &[0, 3])
    }

    #[test]
    fn errors_are_tabulated_and_plotted() {
        let known = r#"{"pairs": {"side": false, "points": [[0, 0], [2, 0.5]], "variants": {"front": [0, -1]}}}"#;
        let evaluation = evaluation(known);
        let rows = "point,x,y,mesh_vertex,coherent,pointwise\r\n0,0,0,0,0,0\r\n1,2,0.5,3,,\r\n";
        assert_eq!(csv(&evaluation), rows);
        let Evaluation::Pairs(pairs) = &evaluation else { panic!("{evaluation:?}") };
        let plot = plot_of(pairs);
        let names: Vec<&str> = plot.curves.iter().map(|curve| curve.name.as_str()).collect();
        assert_eq!(names, ["coherent 0.000", "pointwise 0.000", "front 0.000"]);
        assert_eq!((plot.curves[0].points[0], plot.curves[0].points[50]), ([0.0, 1.0], [0.5, 1.0]));
    }

    #[test]
    fn labels_are_tabulated() {
        let evaluation = evaluation(r#"{"labels": {"sketch": [4, 2], "mesh": [4, 4, 4, -1]}}"#);
        assert_eq!(csv(&evaluation), "sketch_vertex,label,mesh_vertex,found\r\n0,4,0,4\r\n1,2,3,-1\r\n");
    }
}
