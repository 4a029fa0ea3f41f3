//! Cases whose truth is known: folders of silhouettes with dense truth, and drawings with landmarks.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use serde::de::DeserializeOwned;

use super::Unreadable;
use crate::evaluation::truth;
use crate::mesh::file_mesh::FileMesh;
use crate::mesh::formats::{Format, Limits};
use crate::mesh::validation::import;
use crate::sketch::outline::OutlineRequest;
use crate::sketch::{self, Choice, Config, DEFAULT_TARGET_VERTICES, Sketch};

/// A sketch, a mesh, and what is known of how they correspond.
pub struct Case {
    pub name: String,
    /// The name of the folder it is from.
    pub set: String,
    /// What it was drawn from: other forms of the same drawing, and other targets of the same silhouette, share it.
    base: String,
    pub drawing: PathBuf,
    media_type: String,
    pub mesh: PathBuf,
    pub truth: Truth,
}

/// What is known of how a sketch and a mesh correspond.
pub enum Truth {
    /// Points, and their vertices in each way a silhouette can be read.
    Dense(truth::Truth),
    /// Points, and the vertices that are right for each.
    Landmarks(Vec<([f64; 2], Vec<u32>)>),
}

#[derive(Deserialize)]
struct Drawing {
    name: String,
    drawing: PathBuf,
    #[serde(rename = "type")]
    media_type: String,
    meshes: Vec<String>,
    landmarks: Vec<(String, f64, f64)>,
}

#[derive(Deserialize)]
struct Marked {
    file: PathBuf,
    landmarks: BTreeMap<String, Vec<u32>>,
}

/// Endings of files, and the media types of drawings.
const MESHES: [(&str, &str); 5] = [("off", ""), ("obj", ""), ("ply", ""), ("stl", ""), ("glb", "")];
const SKETCHES: [(&str, &str); 4] =
    [("json", "application/json"), ("svg", "image/svg+xml"), ("png", "image/png"), ("jpg", "image/jpeg")];

/// Endings of a drawing's name that tell the form of a drawing that is there in others.
const FORMS: [&str; 4] = ["-png", "-line", "-scribble", "-fill"];

/// The cases of a folder: `cases.json` with `meshes.json` beside it, or a folder for each case with `truth.json`, a mesh and a
/// sketch: the first there is of `mesh.off`, `.obj`, `.ply`, `.stl` and `.glb`, and of `sketch.json`, `.svg`, `.png` and `.jpg`.
///
/// # Errors
/// A file that cannot be read.
pub fn of_folder(folder: &Path) -> Result<Vec<Case>, Unreadable> {
    let set = folder.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
    if folder.join("cases.json").exists() { drawings(folder, &set) } else { silhouettes(folder, &set) }
}

fn silhouettes(folder: &Path, set: &str) -> Result<Vec<Case>, Unreadable> {
    let entries = fs::read_dir(folder).map_err(|error| Unreadable::new(folder, error))?;
    let mut folders: Vec<PathBuf> = entries.filter_map(|entry| Some(entry.ok()?.path())).collect();
    folders.retain(|folder| folder.join("truth.json").exists());
    folders.sort_unstable();
    let case = |folder: PathBuf| {
        let (mesh, _) = first(&folder, "mesh", &MESHES)?;
        let (drawing, media_type) = first(&folder, "sketch", &SKETCHES)?;
        let name = folder.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default();
        Ok(Case {
            base: name.split("__").next().unwrap_or_default().to_owned(),
            name,
            set: set.to_owned(),
            drawing,
            media_type: media_type.to_owned(),
            mesh,
            truth: Truth::Dense(parsed(&folder.join("truth.json"))?),
        })
    };
    folders.into_iter().map(case).collect()
}

/// The first of the files of this name that there is, and its media type.
fn first<'a>(folder: &Path, name: &str, endings: &[(&str, &'a str)]) -> Result<(PathBuf, &'a str), Unreadable> {
    let named = endings.iter().map(|(ending, media_type)| (folder.join(format!("{name}.{ending}")), *media_type));
    named
        .into_iter()
        .find(|(path, _)| path.exists())
        .ok_or_else(|| Unreadable::new(folder, format!("there is no {name}")))
}

fn drawings(folder: &Path, set: &str) -> Result<Vec<Case>, Unreadable> {
    let drawings: Vec<Drawing> = parsed(&folder.join("cases.json"))?;
    let meshes: BTreeMap<String, Marked> = parsed(&folder.join("meshes.json"))?;
    let case = |drawing: &Drawing, target: &String| {
        let mesh = meshes.get(target).ok_or_else(|| Unreadable::new(folder, format!("there is no mesh {target}")))?;
        let right = |name: &String| mesh.landmarks.get(name).cloned();
        let landmarks = drawing.landmarks.iter().filter_map(|(name, x, y)| Some(([*x, *y], right(name)?)));
        Ok(Case {
            name: format!("{}@{target}", drawing.name),
            set: set.to_owned(),
            base: FORMS.iter().fold(drawing.name.clone(), |name, form| name.replace(form, "")),
            drawing: folder.join(&drawing.drawing),
            media_type: drawing.media_type.clone(),
            mesh: folder.join(&mesh.file),
            truth: Truth::Landmarks(landmarks.collect()),
        })
    };
    drawings.iter().flat_map(|drawing| drawing.meshes.iter().map(move |mesh| case(drawing, mesh))).collect()
}

/// The mesh in a file.
///
/// # Errors
/// A file that cannot be read, or that holds no mesh that can be matched.
pub fn mesh(path: &Path) -> Result<FileMesh, Unreadable> {
    let bytes = fs::read(path).map_err(|error| Unreadable::new(path, error))?;
    let named = path.extension().and_then(|ending| Format::from_name(ending.to_str()?));
    let format = named.or_else(|| Format::sniff(&bytes)).ok_or_else(|| Unreadable::new(path, "no mesh"))?;
    Ok(import(&bytes, format, &Limits::default()).map_err(|error| Unreadable::new(path, error))?.mesh)
}

fn parsed<T: DeserializeOwned>(path: &Path) -> Result<T, Unreadable> {
    let bytes = fs::read(path).map_err(|error| Unreadable::new(path, error))?;
    serde_json::from_slice(&bytes).map_err(|error| Unreadable::new(path, error))
}

impl Case {
    /// Whether the case is kept from fitting: one of two, by the hash of what it was drawn from.
    pub fn is_held_back(&self) -> bool {
        blake3::hash(self.base.as_bytes()).as_bytes()[0] % 2 == 1
    }

    /// The drawing, read as the service reads it.
    pub fn sketch(&self) -> Result<Sketch, Unreadable> {
        let bytes = fs::read(&self.drawing).map_err(|error| Unreadable::new(&self.drawing, error))?;
        let config = Config::default();
        let wanted = Choice { vertices: DEFAULT_TARGET_VERTICES, figure: 0 };
        let imported = match self.media_type.as_str() {
            "application/json" => {
                let request: OutlineRequest =
                    serde_json::from_slice(&bytes).map_err(|error| Unreadable::new(&self.drawing, error))?;
                let (drawing, vertices) = request.into_parts();
                sketch::from_outline(&drawing, vertices, &config)
            }
            "image/svg+xml" => sketch::from_svg(&bytes, wanted, &config),
            _ => sketch::from_picture(&bytes, wanted, &config),
        };
        Ok(imported.map_err(|refusal| Unreadable::new(&self.drawing, refusal))?.sketch)
    }
}

impl Truth {
    /// The errors of answers, m vertices at m places of the drawing, each with the number of the place: of dense truth those
    /// of the variant of which their mean is least. `distance` is that of two vertices, none where it is not known.
    pub(super) fn errors(
        &self,
        places: &[[f64; 2]],
        answers: &[u32],
        distance: &dyn Fn(u32, u32) -> Option<f64>,
    ) -> Vec<(usize, f64)> {
        let nearest = |point: &[f64; 2]| {
            let squared = |p: &[f64; 2]| (p[0] - point[0]).powi(2) + (p[1] - point[1]).powi(2);
            (0..places.len()).min_by(|&a, &b| squared(&places[a]).total_cmp(&squared(&places[b]))).unwrap_or(0)
        };
        match self {
            Truth::Dense(truth::Truth { side, points, variants }) => {
                let nearest: Vec<usize> = points.iter().map(nearest).collect();
                let scale = if *side { 0.5f64.sqrt() } else { 1.0 };
                let errors = |variant: &Vec<i64>| -> Vec<(usize, f64)> {
                    let error = |(&at, &right): (&usize, &i64)| {
                        Some((at, distance(answers[at], u32::try_from(right).ok()?)? / scale))
                    };
                    nearest.iter().zip(variant).filter_map(error).collect()
                };
                let all = variants.values().map(errors);
                all.min_by(|a, b| mean(a).total_cmp(&mean(b))).unwrap_or_default()
            }
            Truth::Landmarks(landmarks) => {
                let error = |(point, right): &([f64; 2], Vec<u32>)| {
                    let at = nearest(point);
                    let distances = right.iter().filter_map(|&vertex| distance(answers[at], vertex));
                    Some((at, distances.reduce(f64::min)?))
                };
                landmarks.iter().filter_map(error).collect()
            }
        }
    }
}

/// The mean of errors.
pub(super) fn mean(errors: &[(usize, f64)]) -> f64 {
    errors.iter().map(|(_, error)| error).sum::<f64>() / errors.len().max(1) as f64
}
