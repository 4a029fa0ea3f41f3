//! The requests of an experiment carried out over its cases.

use std::fs;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};

use super::kept::Kept;
use super::matrix::Combination;
use crate::evaluation::pairs::{Judge, PairsEvaluation};
use crate::evaluation::regions;
use crate::evaluation::truth::Truth;
use crate::fitting::{Unreadable, cases};
use crate::mesh::file_mesh::FileMesh;
use crate::numerics::{Cancelled, side_by_side};
use crate::pipeline::outcome::{MatchResult, Matrix};
use crate::pipeline::request::{MatchRequest, Regions};
use crate::pipeline::{self, Settings, Stage, Surroundings, Watcher};
use crate::sketch::Sketch;

/// A case in memory.
pub struct Case {
    pub name: String,
    pub sketch: Sketch,
    pub mesh: FileMesh,
    pub truth: Truth,
    /// Of all that it was read of.
    hash: blake3::Hash,
}

/// What became of one request on one case.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Record {
    pub case: String,
    pub names: Vec<String>,
    /// Whether the case shows one side.
    pub side: bool,
    /// Hash of the request, of the case and of the program's version: a record of another is made anew.
    made_of: String,
    /// What the answer is worth; nothing where there is none.
    pub evaluation: Option<PairsEvaluation>,
    /// Why there is none.
    pub failure: Option<String>,
    /// The functional map.
    pub c: Option<Matrix>,
}

/// A request with its regions taken out where the truth is to make them.
#[derive(Debug)]
struct Request {
    names: Vec<String>,
    text: String,
    settings: Settings,
    /// How many regions the truth makes.
    of_truth: Option<usize>,
}

/// Why an experiment was not carried out.
#[derive(Debug, thiserror::Error)]
pub enum Unrun {
    #[error(transparent)]
    Unreadable(#[from] Unreadable),
    #[error("request \"{name}\": {reason}")]
    Request { name: String, reason: String },
    #[error("there is no case with dense truth: {0}")]
    NoCase(PathBuf),
}

impl Case {
    /// The cases with dense truth in a folder, by name.
    ///
    /// # Errors
    /// A file that cannot be read, a truth that does not fit its mesh or its sketch, no case at all.
    pub fn of_folder(folder: &Path) -> Result<Vec<Case>, Unrun> {
        let all = cases::of_folder(folder)?;
        let cases = side_by_side(&all, Case::read).into_iter().flatten().collect::<Result<Vec<_>, _>>()?;
        if cases.is_empty() { Err(Unrun::NoCase(folder.to_owned())) } else { Ok(cases) }
    }

    fn read(case: &cases::Case) -> Option<Result<Case, Unreadable>> {
        let cases::Truth::Dense(truth) = &case.truth else { return None };
        let read = || {
            let (sketch, mesh) = (case.sketch()?, cases::mesh(&case.mesh)?);
            let misplaced = || truth.misplaced(&sketch.points());
            if let Some(fault) = truth.faults(mesh.positions().len()).into_iter().next().or_else(misplaced) {
                let (folder, reason) =
                    (case.mesh.parent().unwrap_or(&case.mesh), format!("{}: {}", fault.pointer, fault.detail));
                return Err(Unreadable::new(folder, reason));
            }
            let mut hasher = blake3::Hasher::new();
            hasher.update(sketch.content_hash().as_bytes()).update(mesh.content_hash().as_bytes());
            hasher.update(json!(truth).to_string().as_bytes());
            Ok(Case { name: case.name.clone(), sketch, mesh, truth: truth.clone(), hash: hasher.finalize() })
        };
        Some(read())
    }
}

impl Request {
    fn of(combination: &Combination) -> Result<Request, Unrun> {
        let refused = |reason: String| Unrun::Request { name: combination.name(), reason };
        let mut whole = combination.request.clone();
        let text = Value::Object(whole.clone()).to_string();
        let of_truth = taken_out(&mut whole).map_err(refused)?;
        whole.extend(["mesh", "sketch"].map(|shape| (shape.to_owned(), json!(shape))));
        let request: MatchRequest = serde_json::from_value(whole.into()).map_err(|error| refused(error.to_string()))?;
        let settings = Settings::resolve(&request).map_err(|faults| {
            let faults: Vec<String> =
                faults.iter().map(|fault| format!("{}: {}", fault.pointer, fault.detail)).collect();
            refused(faults.join("; "))
        })?;
        Ok(Request { names: combination.names.clone(), text, settings, of_truth })
    }

    /// The record there is of it on a case, or a new one.
    fn record(&self, case: &Case, judge: &Judge<'_>, kept: &Kept, dir: &Path) -> Result<Record, Unreadable> {
        let made_of = blake3::Hasher::new()
            .update(env!("CARGO_PKG_VERSION").as_bytes())
            .update(self.text.as_bytes())
            .update(case.hash.as_bytes())
            .finalize()
            .to_hex()
            .to_string();
        let folder = self.names.iter().fold(dir.to_owned(), |dir, name| dir.join(name));
        let path = folder.join(format!("{}.json", case.name));
        let there = fs::read(&path).ok().and_then(|bytes| serde_json::from_slice::<Record>(&bytes).ok());
        if let Some(record) = there.filter(|record| record.made_of == made_of) {
            return Ok(record);
        }
        let (evaluation, failure, c) = match self.carried_out(case, kept) {
            Ok(result) => {
                let at: Vec<[f64; 2]> = result.correspondences.iter().map(|point| point.point).collect();
                let to: Vec<u32> = result.correspondences.iter().map(|point| point.mesh_vertex).collect();
                let evaluation = judge.evaluation(&case.truth.answers(&at, &to));
                (Some(evaluation), None, Some(result.c))
            }
            Err(reason) => (None, Some(reason), None),
        };
        let (name, names, side) = (case.name.clone(), self.names.clone(), case.truth.side);
        let record = Record { case: name, names, side, made_of, evaluation, failure, c };
        // What is cut off by an end in between is not taken for a record.
        let unwritten = |error: std::io::Error| Unreadable::new(&path, error);
        fs::create_dir_all(&folder).map_err(unwritten)?;
        let begun = folder.join(format!("{}.part", case.name));
        fs::write(&begun, json!(record).to_string()).and_then(|()| fs::rename(&begun, &path)).map_err(unwritten)?;
        Ok(record)
    }

    fn carried_out(&self, case: &Case, kept: &Kept) -> Result<MatchResult, String> {
        let mut settings = self.settings.clone();
        if let Some(count) = self.of_truth {
            let [sketch, mesh] =
                regions::of_truth(&case.truth, count, (case.sketch.mesh(), &case.sketch.points()), &case.mesh);
            settings.regions = Regions::Given { sketch, mesh };
        }
        let surroundings =
            Surroundings { spectra: kept, preparations: kept, watcher: &Patient, clock: &|| 0.0, preview: None };
        pipeline::run(&case.sketch, &case.mesh, &settings, &surroundings).map_err(|error| error.to_string())
    }
}

/// The answers to every combination over cases, in their order; nothing where there is none.
///
/// # Errors
/// [`Unrun`]: a request that is none.
pub fn answers(combinations: &[Combination], cases: &[Case]) -> Result<Vec<Vec<Option<MatchResult>>>, Unrun> {
    let requests = combinations.iter().map(Request::of).collect::<Result<Vec<_>, _>>()?;
    let kept = Kept::default();
    let over_cases = |request: &Request| side_by_side(cases, |case| request.carried_out(case, &kept).ok());
    Ok(requests.iter().map(over_cases).collect())
}

/// How many regions the truth is to make: `{"method": "truth", "count": 4}`, which is taken out of the request.
fn taken_out(request: &mut Map<String, Value>) -> Result<Option<usize>, String> {
    let Some(regions) = request.get("regions").filter(|regions| regions["method"] == "truth") else { return Ok(None) };
    let count = regions["count"].as_u64().filter(|count| (1..=crate::regions::MAX_REGIONS as u64).contains(count));
    let count = count.ok_or_else(|| format!("/regions/count: must be 1 to {}", crate::regions::MAX_REGIONS))?;
    request.remove("regions");
    Ok(Some(count as usize))
}

/// Nobody waits, and nobody cancels.
struct Patient;

impl Watcher for Patient {
    fn proceed(&self, _stage: Stage, _fraction: f64) -> Result<(), Cancelled> {
        Ok(())
    }
}

/// Every combination carried out over every case, the cases within each in their order. Records are kept in a folder of
/// `dir` for each name, and what is there already is not done again; `done` is told of each.
///
/// # Errors
/// [`Unrun`]: a request that is none, before anything is done; a file that cannot be written.
pub fn run(
    combinations: &[Combination],
    cases: &[Case],
    dir: &Path,
    done: &(dyn Fn(&Record) + Sync),
) -> Result<Vec<Record>, Unrun> {
    let requests = combinations.iter().map(Request::of).collect::<Result<Vec<_>, _>>()?;
    let kept = Kept::default();
    // All requests of a case after each other: threads then seldom wait for the same spectrum.
    let judges: Vec<Judge<'_>> = cases.iter().map(|case| Judge::new(&case.truth, &case.mesh)).collect();
    let judged = cases.iter().zip(&judges);
    let tasks: Vec<_> = judged.flat_map(|(case, judge)| requests.iter().map(move |r| (case, judge, r))).collect();
    let records = side_by_side(&tasks, |(case, judge, request)| {
        request.record(case, judge, &kept, dir).inspect(|record| done(record))
    });
    let mut records = records.into_iter().collect::<Result<Vec<_>, _>>()?;
    records.sort_by_key(|record| requests.iter().position(|request| request.names == record.names));
    Ok(records)
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::{AtomicUsize, Ordering};

    use super::*;
    use crate::example::obj;
    use crate::experiments::matrix::combinations;
    use crate::mesh::TriangleMesh;
    use crate::mesh::solids::sphere;

    fn matrix(value: Value) -> Vec<Combination> {
        combinations(&serde_json::from_value(value).unwrap()).unwrap()
    }

    /// Two cases: an ellipse and an ellipsoid, whose truth is made up.
    fn cases(dir: &Path) -> Vec<Case> {
        let round = |i: usize, n: usize| (std::f64::consts::TAU * i as f64 / n as f64).sin_cos();
        let outline: Vec<[f64; 2]> = (0..24).map(|i| round(i, 24)).map(|(y, x)| [200.0 * x, 100.0 * y]).collect();
        let ball = sphere(9, 12);
        let positions = ball.positions().iter().map(|&[x, y, z]| [2.0 * x, y, z]).collect();
        let mesh = obj(&TriangleMesh::new(positions, ball.triangles().to_vec()).unwrap());
        let points: Vec<[f64; 2]> = (0..8).map(|i| round(i, 8)).map(|(y, x)| [100.0 * x, 50.0 * y]).collect();
        let truth = json!({"side": false, "points": points, "variants": {"front": [3, 14, 25, 36, 47, 58, 69, 80]}});
        for name in ["a", "b"] {
            let folder = dir.join(name);
            fs::create_dir_all(&folder).unwrap();
            let sketch = json!({"outline": outline, "target_vertices": 60}).to_string();
            for (file, text) in [("sketch.json", &sketch), ("mesh.obj", &mesh), ("truth.json", &truth.to_string())] {
                fs::write(folder.join(file), text).unwrap();
            }
        }
        Case::of_folder(dir).unwrap()
    }

    #[test]
    fn an_experiment_goes_on_where_it_stopped() {
        let dir = tempfile::tempdir().unwrap();
        let (cases, out) = (cases(&dir.path().join("cases")), dir.path().join("out"));
        assert_eq!(cases.iter().map(|case| case.name.as_str()).collect::<Vec<_>>(), ["a", "b"]);
        let regions = json!({"regions": {"method": "truth", "count": 4}, "preset": "thesis"});
        let all = matrix(json!([
            {"given": regions},
            {"l1": {"regulariser": {"type": "l1"}}, "too_many": {"basis": {"k": 500}, "refinement": {"method": "zoomout", "k": 500}}},
        ]));
        let first = run(&all[..1], &cases, &out, &|_| ()).unwrap();
        let l1 = first[0].evaluation.as_ref().unwrap();
        assert!(l1.coherent.mean < 1.0 && first[0].c.is_some(), "{}", l1.coherent.mean);
        // The same shapes under another name.
        assert_eq!(first[0].evaluation, first[1].evaluation);
        // Changed by hand, so that it is seen whether it is taken as it is.
        let path = out.join("given/l1/a.json");
        let text = fs::read_to_string(&path).unwrap();
        fs::write(&path, text.replace("\"case\":\"a\"", "\"case\":\"kept\"")).unwrap();
        fs::write(out.join("given/l1/b.json"), &text[..text.len() / 2]).unwrap();
        let told = AtomicUsize::new(0);
        let count = |_: &Record| {
            told.fetch_add(1, Ordering::Relaxed);
        };
        let second = run(&all, &cases, &out, &count).unwrap();
        assert_eq!(told.into_inner(), 4);
        assert_eq!((second[0].case.as_str(), &second[1]), ("kept", &first[1]));
        assert_eq!(second[2].names, ["given", "too_many"]);
        assert!(second[2].failure.as_ref().unwrap().contains("/basis/k") && second[2].evaluation.is_none());
    }

    #[test]
    fn what_is_no_request_is_refused_before_anything_is_done() {
        let dir = tempfile::tempdir().unwrap();
        for (request, reason) in [
            (json!({"regulariser": {"type": "l1", "gamma": -1}}), "/regulariser/gamma"),
            (json!({"regularizer": {}}), "regularizer"),
            (json!({"regions": {"method": "truth"}}), "/regions/count"),
        ] {
            let error = run(&matrix(json!([{"a": request}])), &[], dir.path(), &|_| ()).unwrap_err().to_string();
            assert!(error.starts_with("request \"a\": ") && error.contains(reason), "{error}");
        }
        assert!(matches!(Case::of_folder(dir.path()), Err(Unrun::NoCase(_))));
    }
}
