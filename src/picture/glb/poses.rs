//! Where the vertices of a file are at rest and in poses, in single precision.

use std::ops::Range;

use serde_json::{Map, Value, json};

use super::content::{ARRAY_BUFFER, Content};
use crate::mesh::file_mesh::FileMesh;
use crate::mesh::normals::normals;

/// Single precision holds the coordinates of a file well where the mesh is no farther from the origin than this many
/// times its extent.
const FAR: f64 = 1024.0;
/// And where the extent is between these.
const SIZES: std::ops::RangeInclusive<f64> = 1e-18..=1e18;
/// Where a vertex of no triangle faces.
const NOWHERE: [f64; 3] = [0.0, 0.0, 1.0];

/// The places of a file's n vertices, and where the surface faces there.
struct Places {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
}

/// A mesh at rest, and how far its poses are from that.
pub struct Poses {
    rest: Places,
    targets: Vec<Places>,
}

impl Poses {
    /// Of poses, places of the file's vertices, one takes the place of the mesh's own, and several are morph targets.
    pub fn of(mesh: &FileMesh, poses: &[Vec<[f64; 3]>]) -> Poses {
        let single = Single::of(mesh);
        let places = |places: &[[f64; 3]]| {
            let own = mesh.origins().iter().map(|&v| places[v as usize]).collect::<Vec<_>>();
            let normals = normals(&own, mesh.sound().triangles());
            let facing = |v: u32| mesh.sound_vertices(v).next().map_or(NOWHERE, |own| normals[own as usize]);
            Places {
                positions: places.iter().map(|&p| single.place(p)).collect(),
                normals: (0..places.len() as u32).map(|v| facing(v).map(|x| x as f32)).collect(),
            }
        };
        let (rest, targets) = match poses {
            [one] => (one.as_slice(), &[][..]),
            targets => (mesh.positions(), targets),
        };
        let rest = places(rest);
        let offsets = |to: &[[f32; 3]], from: &[[f32; 3]]| -> Vec<[f32; 3]> {
            to.iter().zip(from).map(|(to, from)| std::array::from_fn(|i| to[i] - from[i])).collect()
        };
        let targets = targets.iter().map(|target| places(target)).map(|to| Places {
            positions: offsets(&to.positions, &rest.positions),
            normals: offsets(&to.normals, &rest.normals),
        });
        Poses { targets: targets.collect(), rest }
    }

    /// Gives a primitive some of the vertices.
    pub fn put(&self, primitive: &mut Map<String, Value>, vertices: Range<usize>, content: &mut Content) {
        let attributes = primitive.entry("attributes").or_insert_with(|| json!({}));
        let Places { positions, normals } = &self.rest;
        attributes["POSITION"] = json!(content.triples(&positions[vertices.clone()], true, Some(ARRAY_BUFFER)));
        attributes["NORMAL"] = json!(content.triples(&normals[vertices.clone()], false, Some(ARRAY_BUFFER)));
        if !self.targets.is_empty() {
            let targets = self.targets.iter().map(|Places { positions, normals }| {
                let position = content.triples(&positions[vertices.clone()], true, None);
                json!({"POSITION": position, "NORMAL": content.triples(&normals[vertices.clone()], false, None)})
            });
            primitive.insert("targets".into(), targets.collect());
        }
    }

    /// Puts a mesh of primitives into a document, with an animation through its morph targets.
    pub fn show(&self, primitives: Vec<Value>, document: &mut Map<String, Value>, content: &mut Content) {
        let mut mesh = json!({"primitives": primitives});
        let count = self.targets.len();
        if count > 0 {
            mesh["weights"] = (0..count).map(|i| u8::from(i == 0)).collect();
            document.insert("animations".into(), json!([content.animation(count)]));
        }
        document.insert("meshes".into(), json!([mesh]));
    }
}

/// How the coordinates of a mesh become numbers of single precision, all finite.
struct Single {
    middle: [f64; 3],
    scale: f64,
}

impl Single {
    fn of(mesh: &FileMesh) -> Single {
        let (mut low, mut high) = ([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]);
        for &v in mesh.triangles().as_flattened() {
            let p = mesh.positions()[v as usize];
            (0..3).for_each(|i| (low[i], high[i]) = (low[i].min(p[i]), high[i].max(p[i])));
        }
        let extent = (0..3).map(|i| high[i] - low[i]).fold(0.0, f64::max);
        let farthest = low.into_iter().chain(high).map(f64::abs).fold(0.0, f64::max);
        if farthest <= FAR * extent && SIZES.contains(&extent) {
            return Single { middle: [0.0; 3], scale: 1.0 };
        }
        Single { middle: std::array::from_fn(|i| low[i] + 0.5 * (high[i] - low[i])), scale: extent.recip() }
    }

    fn place(&self, p: [f64; 3]) -> [f32; 3] {
        // Vertices of no triangle may lie anywhere, or nowhere.
        let within = |x: f64| if x.is_nan() { 0.0 } else { (x as f32).clamp(f32::MIN, f32::MAX) };
        std::array::from_fn(|i| within((p[i] - self.middle[i]) * self.scale))
    }
}
