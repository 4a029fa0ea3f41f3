//! Chapter 4 of the thesis again: descriptors and regularisers (figs. 4.2 and 4.3), C as pictures (fig. 4.4), conversions and
//! rounds of refinement (fig. 4.5), and all methods there are.

use serde_json::{Value, json};

use super::matrix::{Combination, Matrix, Unfit, combinations};
use super::run::Record;
use super::tables::{Summary, plots, summaries, summary_csv};
use crate::export::Unwritten;
use crate::picture::{heat_map, plot};

/// Plots beside each other.
const COLUMNS: usize = 3;

/// A file of an experiment: its name and content.
pub type File = (String, Vec<u8>);

/// The descriptors and the regulariser that figs. 4.3 and 4.4 show.
const SHOWN: &str = "wks";

/// What a part of the experiment is called, and its requests.
pub struct Part {
    pub name: &'static str,
    pub combinations: Vec<Combination>,
}

/// The parts of the experiment.
///
/// # Errors
/// [`Unfit`]; there is none.
pub fn parts() -> Result<Vec<Part>, Unfit> {
    let part = |name, axes: Value| {
        let matrix: Matrix = serde_json::from_value(axes).unwrap_or_default();
        Ok(Part { name, combinations: combinations(&matrix)? })
    };
    Ok(vec![
        part("descriptors", json!([regions(), regularisers(), descriptors()]))?,
        part("conversions", json!([regions(), conversions()]))?,
        part("methods", json!([regions(), methods()]))?,
    ])
}

/// Regions of the truth in place of the thesis's hand, and found without one.
fn regions() -> Value {
    json!({
        "automatic": {"preset": "thesis", "regions": {"method": "auto", "count": 7}},
        "truth": {"preset": "thesis", "regions": {"method": "truth", "count": 7}},
    })
}

fn regularisers() -> Value {
    json!({
        "l1": {"regulariser": {"type": "l1"}},
        "l2": {"regulariser": {"type": "l2"}},
        "nuclear": {"regulariser": {"type": "nuclear"}},
    })
}

fn descriptors() -> Value {
    let counts = |heat: usize, wave: usize| json!({"descriptors": {"hks": {"count": heat}, "wks": {"count": wave}}});
    json!({"regions": counts(0, 0), "hks": counts(100, 0), "wks": counts(0, 100), "both": counts(100, 100)})
}

fn conversions() -> Value {
    let nearest = |rounds: usize| {
        let refinement =
            if rounds == 0 { json!({"method": "none"}) } else { json!({"method": "icp", "iterations": rounds}) };
        json!({"conversion": {"method": "nearest"}, "refinement": refinement})
    };
    json!({
        "indicator": {"conversion": {"method": "indicator"}},
        "nearest_00": nearest(0), "nearest_01": nearest(1), "nearest_02": nearest(2), "nearest_05": nearest(5),
        "nearest_10": nearest(10),
    })
}

/// Every regulariser, weights and term, converted by nearest neighbours.
fn methods() -> Value {
    let nearest = |besides: Value| {
        let mut request = json!({"conversion": {"method": "nearest"}});
        if let (Some(request), Some(besides)) = (request.as_object_mut(), besides.as_object()) {
            request.extend(besides.clone());
        }
        request
    };
    let regulariser = |name: &str| nearest(json!({"regulariser": {"type": name}}));
    let term = |name: &str| nearest(json!({"regulariser": {"type": "l1"}, "terms": [{"type": name}]}));
    let weights = |name: &str| nearest(json!({"regulariser": {"type": "l1"}, "weights": {"method": name}}));
    json!({
        "none": regulariser("none"), "l1": regulariser("l1"), "l2": regulariser("l2"), "nuclear": regulariser("nuclear"),
        "permuted_l1": regulariser("permuted_l1"), "matrix_completion": regulariser("matrix_completion"),
        "part_indicator": regulariser("part_indicator"),
        "l1_laplacian": term("laplacian"), "l1_descriptors": term("descriptors"), "l1_orientation": term("orientation"),
        "l1_slant": weights("slant"), "l1_resolvent": weights("resolvent"),
        "l1_coupled": nearest(json!({"basis": {"coupling": {"method": "joint_diagonalisation"}}, "weights": {"method": "slant"}})),
        "l1_zoomout": nearest(json!({"refinement": {"method": "zoomout", "k": 60}})),
        "l1_zoomout_part": nearest(json!({"refinement": {"method": "zoomout", "k": 60, "within": "part"}})),
    })
}

/// The files that the records of a part come to: its table, the curves of side and whole, and of the descriptors also fig. 4.3 and
/// C as pictures.
///
/// # Errors
/// What an encoder reports.
pub fn files(part: &str, records: &[Record]) -> Result<Vec<File>, Unwritten> {
    let mut files = Vec::new();
    for (name, side) in [("side", true), ("whole", false)] {
        let of_kind = summaries(records, |record| record.side == side);
        if of_kind.is_empty() {
            continue;
        }
        files.push((format!("{part}_{name}.csv"), summary_csv(&of_kind).into_bytes()));
        files.extend(curves(&format!("{part}_{name}"), name, &of_kind)?);
        if part == "descriptors" {
            // The same with one kind of descriptors, so that the regularisers are the curves.
            let shown: Vec<Summary> =
                of_kind.iter().filter(|s| s.names.last().is_some_and(|last| last == SHOWN)).cloned().collect();
            let named = shown.into_iter().map(|summary| Summary { names: summary.names[..2].to_vec(), ..summary });
            files.extend(curves(&format!("regularisers_{name}"), name, &named.collect::<Vec<_>>())?);
        }
    }
    if part == "descriptors" {
        files.extend(maps(records)?);
    }
    Ok(files)
}

fn curves(file: &str, title: &str, summaries: &[Summary]) -> Result<[File; 2], Unwritten> {
    let plots = plots(title, summaries);
    let svg = plot::svg(&plots, COLUMNS).into_bytes();
    Ok([(format!("{file}.svg"), svg), (format!("{file}.png"), plot::png(&plots, COLUMNS)?)])
}

/// C of the first case of a side and of the first of the whole, for every regulariser.
fn maps(records: &[Record]) -> Result<Vec<File>, Unwritten> {
    let mut files = Vec::new();
    for (name, side) in [("side", true), ("whole", false)] {
        let of_kind = records.iter().filter(|record| record.side == side);
        let first = of_kind.clone().map(|record| &record.case).min();
        let shown = of_kind.filter(|record| Some(&record.case) == first && record.names[2..] == [SHOWN]);
        for record in shown {
            let Some(c) = &record.c else { continue };
            let file = format!("c_{name}_{}_{}.png", record.names[0], record.names[1]);
            files.push((file, heat_map::png(&c.values)?));
        }
    }
    Ok(files)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::evaluation::measures::Measures;
    use crate::pipeline::Settings;
    use crate::pipeline::request::MatchRequest;

    #[test]
    fn every_request_can_be_asked_for() {
        let parts = parts().unwrap();
        let counts: Vec<usize> = parts.iter().map(|part| part.combinations.len()).collect();
        assert_eq!(counts, [24, 12, 30]);
        for combination in parts.iter().flat_map(|part| &part.combinations) {
            let mut request = combination.request.clone();
            request.remove("regions");
            request.extend(["mesh", "sketch"].map(|name| (name.to_owned(), json!(name))));
            let request: MatchRequest = serde_json::from_value(request.into()).unwrap();
            assert!(Settings::resolve(&request).is_ok(), "{}", combination.name());
        }
    }

    #[test]
    fn the_figures_are_made_of_the_records() {
        let measures = json!(Measures::of(&[0.1, 0.2]));
        let record = |names: &[String], case: &str, side: bool| -> Record {
            serde_json::from_value(json!({
                "case": case, "names": names, "side": side, "made_of": "", "failure": null,
                "evaluation": {
                    "unit": 1.0, "best": "front", "coherent": measures, "pointwise": measures, "variants": {},
                    "thresholds": [], "points": [],
                },
                "c": {"rows": 2, "columns": 2, "values": [[1, 0], [0, -1]]},
            }))
            .unwrap()
        };
        let part = &parts().unwrap()[0];
        let of = |combination: &Combination| {
            [record(&combination.names, "cat", true), record(&combination.names, "man", false)]
        };
        let records: Vec<Record> = part.combinations.iter().flat_map(of).collect();
        let files = files(part.name, &records).unwrap();
        let names: BTreeSet<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
        for wanted in
            ["descriptors_side.csv", "descriptors_whole.svg", "regularisers_side.png", "c_whole_truth_nuclear.png"]
        {
            assert!(names.contains(wanted), "{wanted}: {names:?}");
        }
        assert_eq!(names.len(), 2 * (1 + 2 + 2) + 2 * 6);
        assert_eq!(files, super::files(part.name, &records).unwrap());
    }
}
