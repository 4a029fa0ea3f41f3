//! Where the bones of a skinned mesh place its vertices.

use gltf::{Primitive, Semantic, Skin};

use super::container::Container;
use super::matrix::{IDENTITY, Matrix, determinant, placed, product};

/// How far the matrix of a bone may be from the identity by rounding; of its translation as a share of how far out bones
/// are.
const AT_REST: f64 = 1e-4;
/// Most bones of a skin, and most sets of four bones for a vertex.
const MOST_BONES: usize = 1 << 12;
const MOST_SETS: u32 = 4;

/// The matrices of the bones of a skin.
pub(super) struct Bones(Vec<Matrix>);

/// Per vertex four bones that move it, and how much each does.
type Influences = Vec<([f64; 4], [f64; 4])>;

impl Bones {
    /// The bones of a skin, `worlds` being where every node of the file is; nothing where the pose is the one the mesh was
    /// made in, so that its vertices are where they should be.
    pub fn of(skin: &Skin, worlds: &[Matrix], container: &Container) -> Result<Option<Bones>, String> {
        let joints: Vec<Matrix> = skin.joints().take(MOST_BONES + 1).map(|node| worlds[node.index()]).collect();
        if joints.len() > MOST_BONES {
            return Err(format!("skin {} has more than {MOST_BONES} bones", skin.index()));
        }
        let inverse = match skin.inverse_bind_matrices() {
            Some(accessor) if accessor.count() > joints.len() => return Err(unequal(skin)),
            Some(accessor) => container.numbers::<16>(&accessor)?,
            None => vec![std::array::from_fn(|i| IDENTITY[i / 4][i % 4]); joints.len()],
        };
        if inverse.len() < joints.len() {
            return Err(unequal(skin));
        }
        let by_columns = |m: &[f64; 16]| [0, 4, 8, 12].map(|i| [m[i], m[i + 1], m[i + 2], m[i + 3]]);
        let reach = joints.iter().flat_map(|m| &m[3][..3]).fold(0.0, |reach: f64, x| reach.max(x.abs()));
        let bones: Vec<Matrix> = joints.iter().zip(&inverse).map(|(&m, i)| product(m, by_columns(i))).collect();
        let rests = |m: &Matrix| {
            let near = |column: usize, most: f64| (0..3).all(|i| (m[column][i] - IDENTITY[column][i]).abs() <= most);
            (0..3).all(|column| near(column, AT_REST)) && near(3, AT_REST * reach)
        };
        Ok(if bones.iter().all(rests) { None } else { Some(Bones(bones)) })
    }

    /// Whether the bones turn the mesh inside out.
    pub fn mirror(&self) -> bool {
        self.0.first().is_some_and(|m| determinant(m) < 0.0)
    }

    /// The vertices of a primitive where its bones place them.
    pub fn place(
        &self,
        positions: &mut [[f64; 3]],
        primitive: &Primitive,
        container: &Container,
    ) -> Result<(), String> {
        let mut influences: Vec<Influences> = Vec::new();
        for set in 0..MOST_SETS {
            let (Some(joints), Some(weights)) =
                (primitive.get(&Semantic::Joints(set)), primitive.get(&Semantic::Weights(set)))
            else {
                break;
            };
            if joints.count() != positions.len() || weights.count() != positions.len() {
                return Err("it does not have bones for every vertex".into());
            }
            let (joints, weights) = (container.numbers::<4>(&joints)?, container.numbers::<4>(&weights)?);
            influences.push(joints.into_iter().zip(weights).collect());
        }
        for (v, position) in positions.iter_mut().enumerate() {
            let pulls =
                influences.iter().map(|set| set[v]).flat_map(|(j, w)| [0, 1, 2, 3].map(|i: usize| (j[i], w[i])));
            let mut sum = [0.0; 3];
            let mut total = 0.0;
            for (joint, weight) in pulls.filter(|(_, weight)| *weight != 0.0) {
                let bone = self
                    .0
                    .get(joint as usize)
                    .ok_or_else(|| format!("vertex {v} hangs on a bone that is not there"))?;
                let p = placed(bone, *position);
                sum = [0, 1, 2].map(|i: usize| sum[i] + weight * p[i]);
                total += weight;
            }
            if total > 0.0 {
                *position = sum.map(|x| x / total);
            }
        }
        Ok(())
    }
}

fn unequal(skin: &Skin) -> String {
    format!("skin {} does not have one inverse bind matrix for every bone", skin.index())
}
