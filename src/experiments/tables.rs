//! What the records of an experiment come to.

use std::fmt::Write;

use super::run::Record;
use crate::evaluation::measures::{Measures, mean, thresholds};
use crate::export::evaluation::{number, plot};
use crate::picture::plot::{Curve, Plot, longest_name};

/// The error of a case without an answer.
const OF_FAILURE: f64 = 1.0;

/// Means over the cases of one combination; a case without an answer counts with an error of 1.
#[derive(Clone, Debug, PartialEq)]
pub struct Summary {
    pub names: Vec<String>,
    pub cases: usize,
    pub failed: usize,
    /// Mean over the cases of the mean error.
    pub coherent: f64,
    pub pointwise: f64,
    pub within_005: f64,
    pub within_01: f64,
    pub within_02: f64,
    pub auc: f64,
    /// Mean over the cases of the curve of coherent errors.
    pub curve: Vec<f64>,
}

impl Summary {
    /// The means over records of one combination.
    fn of(records: &[&Record]) -> Summary {
        let measured = |of: &dyn Fn(&Record) -> Option<f64>, failed: f64| {
            let values: Vec<f64> = records.iter().map(|record| of(record).unwrap_or(failed)).collect();
            mean(&values)
        };
        let coherent = |record: &Record, of: &dyn Fn(&Measures) -> f64| Some(of(&record.evaluation.as_ref()?.coherent));
        let within = |limit: f64| measured(&|record| coherent(record, &|m| m.share_within(limit)), 0.0);
        let curve = (0..thresholds().len()).map(|i| measured(&|record| coherent(record, &|m| m.curve[i]), 0.0));
        Summary {
            names: records.first().map(|record| record.names.clone()).unwrap_or_default(),
            cases: records.len(),
            failed: records.iter().filter(|record| record.evaluation.is_none()).count(),
            coherent: measured(&|record| coherent(record, &|m| m.mean), OF_FAILURE),
            pointwise: measured(&|record| Some(record.evaluation.as_ref()?.pointwise.mean), OF_FAILURE),
            within_005: within(0.05),
            within_01: within(0.1),
            within_02: within(0.2),
            auc: measured(&|record| coherent(record, &|m| m.auc), 0.0),
            curve: curve.collect(),
        }
    }
}

/// The means of every combination, in the order of the records, over those of them that `take` takes.
pub fn summaries(records: &[Record], take: impl Fn(&Record) -> bool) -> Vec<Summary> {
    let of_combination = records.chunk_by(|a, b| a.names == b.names);
    let taken = of_combination.map(|records| records.iter().filter(|record| take(record)).collect::<Vec<_>>());
    taken.filter(|records| !records.is_empty()).map(|records| Summary::of(&records)).collect()
}

const MEASURES: &str = "coherent,pointwise,within_005,within_01,within_02,auc";

/// Every record as a row of a table (RFC 4180).
pub fn csv(records: &[Record]) -> String {
    let mut table = format!("request,case,side,{MEASURES},failure\r\n");
    for record in records {
        let Summary { coherent, pointwise, within_005, within_01, within_02, auc, .. } = Summary::of(&[record]);
        let numbers = [coherent, pointwise, within_005, within_01, within_02, auc].map(number).join(",");
        let failure = record.failure.as_deref().map(quoted).unwrap_or_default();
        // Writing to a string cannot fail.
        let _ = write!(
            table,
            "{},{},{},{numbers},{failure}\r\n",
            record.names.join(" "),
            quoted(&record.case),
            record.side
        );
    }
    table
}

/// Every summary as a row of a table.
pub fn summary_csv(summaries: &[Summary]) -> String {
    let mut table = format!("request,cases,failed,{MEASURES}\r\n");
    for Summary { names, cases, failed, coherent, pointwise, within_005, within_01, within_02, auc, .. } in summaries {
        let numbers = [coherent, pointwise, within_005, within_01, within_02, auc].map(|x| number(*x)).join(",");
        let _ = write!(table, "{},{cases},{failed},{numbers}\r\n", names.join(" "));
    }
    table
}

/// The same as people read it.
pub fn summary_text(summaries: &[Summary]) -> String {
    let wide = summaries.iter().map(|summary| summary.names.join(" ").len()).max().unwrap_or(0).max(7);
    let mut text = format!("{:wide$}  cases failed coherent pointwise  <.05  <.10  <.20   AUC\n", "request");
    for s in summaries {
        let _ = writeln!(
            text,
            "{:wide$}  {:5} {:6} {:8.3} {:9.3} {:5.2} {:5.2} {:5.2} {:5.3}",
            s.names.join(" "),
            s.cases,
            s.failed,
            s.coherent,
            s.pointwise,
            s.within_005,
            s.within_01,
            s.within_02,
            s.auc
        );
    }
    text
}

/// A text as a field of a table.
fn quoted(text: &str) -> String {
    let plain = !text.contains([',', '"', '\r', '\n']);
    if plain { text.to_owned() } else { format!("\"{}\"", text.replace('"', "\"\"")) }
}

/// The curves of summaries, a plot for every combination of all names but the last, by which its curves are named.
pub fn plots(title: &str, summaries: &[Summary]) -> Vec<Plot> {
    let alike = summaries.chunk_by(|a, b| {
        let before = |summary: &Summary| summary.names.len().saturating_sub(1);
        a.names[..before(a)] == b.names[..before(b)]
    });
    alike
        .map(|alike| {
            let before = &alike[0].names[..alike[0].names.len().saturating_sub(1)];
            let curves = alike.iter().enumerate().map(|(i, summary)| curve(i, summary)).collect();
            let title: Vec<&str> = std::iter::once(title).chain(before.iter().map(String::as_str)).collect();
            plot(title.join(" · "), curves)
        })
        .collect()
}

/// The curve of a summary, called by its last name.
fn curve(number: usize, summary: &Summary) -> Curve {
    let name = summary.names.last().map_or("request", String::as_str);
    let name: String = name.chars().take(longest_name() - 6).collect();
    let points = thresholds().into_iter().zip(&summary.curve).map(|(t, &share)| [t, share]).collect();
    Curve { name: format!("{name} {:.3}", summary.coherent), colour: number, points }
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn record(names: [&str; 2], case: &str, side: bool, error: Option<f64>) -> Record {
        let measures = |error: f64| json!(Measures::of(&[error]));
        let evaluation = error.map(|error| {
            json!({
                "unit": 1.0, "best": "front", "coherent": measures(error), "pointwise": measures(error / 2.0),
                "variants": {}, "thresholds": [], "points": [],
            })
        });
        let failure = error.is_none().then_some("no, not \"at all\"");
        serde_json::from_value(json!({
            "case": case, "names": names, "side": side, "made_of": "", "evaluation": evaluation, "failure": failure,
        }))
        .unwrap()
    }

    fn records() -> Vec<Record> {
        vec![
            record(["a", "x"], "cat", true, Some(0.1)),
            record(["a", "x"], "man", false, Some(0.3)),
            record(["a", "y"], "cat", true, None),
            record(["b", "x"], "cat", true, Some(0.02)),
        ]
    }

    #[test]
    fn a_case_without_an_answer_counts_with_an_error_of_one() {
        let all = summaries(&records(), |_| true);
        let means: Vec<_> = all.iter().map(|s| (s.cases, s.failed, s.coherent, s.within_01)).collect();
        assert_eq!(means, [(2, 0, 0.2, 0.5), (1, 1, 1.0, 0.0), (1, 0, 0.02, 1.0)]);
        assert_eq!(summaries(&records(), |record| !record.side).len(), 1);
    }

    #[test]
    fn records_are_tabulated() {
        let table = csv(&records());
        let rows: Vec<&str> = table.split("\r\n").collect();
        assert_eq!(rows[1], "a x,cat,true,0.1,0.05,0,1,1,0.803921568627451,");
        assert_eq!(rows[3], "a y,cat,true,1,1,0,0,0,0,\"no, not \"\"at all\"\"\"");
        assert!(summary_csv(&summaries(&records(), |_| true)).contains("\r\na x,2,0,0.2,0.1,0,0.5,0.5,"));
        assert!(summary_text(&summaries(&records(), |_| true)).contains("a y          1      1    1.000"));
    }

    #[test]
    fn every_combination_of_the_names_before_the_last_has_a_plot() {
        let plots = plots("side", &summaries(&records(), |record| record.side));
        let titles: Vec<&str> = plots.iter().map(|plot| plot.title.as_str()).collect();
        assert_eq!(titles, ["side · a", "side · b"]);
        let names: Vec<&str> = plots[0].curves.iter().map(|curve| curve.name.as_str()).collect();
        assert_eq!(names, ["x 0.100", "y 1.000"]);
    }
}
