//! As-rigid-as-possible deformation of a flat shape [SA07].

use faer::Mat;
use sprs::CsMat;

use super::links::{Link, edges, laplacian};
use super::similarity::Similarity;
use crate::mesh::TriangleMesh;
use crate::numerics::cholesky::{Analysis, FactorisationError, SparseCholesky};

/// Turns of local rotations and global positions.
const ROUNDS: usize = 8;

/// A vertex of the shape drawn to a place, with the weight of the squared distance beside the elastic energy.
#[derive(Clone, Copy, Debug)]
pub struct Pull {
    pub vertex: u32,
    pub target: [f64; 2],
    pub weight: f64,
}

/// What holds a flat shape of m vertices together.
pub struct Elastic {
    pub edges: Vec<Link>,
    /// 2 L of these weights, m × m, and its analysis, which that with another diagonal has too.
    laplacian: CsMat<f64>,
    analysis: Analysis,
}

impl Elastic {
    /// What holds a mesh together; its size means nothing.
    ///
    /// # Errors
    /// [`FactorisationError::OutOfMemory`].
    pub fn new(mesh: &TriangleMesh) -> Result<Elastic, FactorisationError> {
        Elastic::of(edges(mesh), mesh.positions().len())
    }

    /// What links hold together, which leave none of so many vertices alone.
    ///
    /// # Errors
    /// [`FactorisationError::OutOfMemory`].
    pub fn of(edges: Vec<Link>, count: usize) -> Result<Elastic, FactorisationError> {
        let laplacian = laplacian(&edges, count).map(|entry| 2.0 * entry);
        Ok(Elastic { edges, analysis: Analysis::new(&laplacian)?, laplacian })
    }
}

impl Elastic {
    /// How far apart the vertices are that hold together: the weighted sum of their squared distances.
    pub fn size(&self, places: &[[f64; 2]]) -> f64 {
        let squared = |&(i, j, weight): &Link| {
            let (p, q) = (places[i as usize], places[j as usize]);
            weight * ((p[0] - q[0]).powi(2) + (p[1] - q[1]).powi(2))
        };
        self.edges.iter().map(squared).sum()
    }
}

/// The positions (m × 2) of least elastic energy under the pulls. The shape at `rest` (m × 2) is scaled by the similarity
/// that fits the pulls best, so that a shape of another size is no strain.
///
/// # Errors
/// Where the pulls leave the position undetermined.
pub fn deformed(elastic: &Elastic, rest: &[[f64; 2]], pulls: &[Pull]) -> Result<Vec<[f64; 2]>, FactorisationError> {
    let fitted = Similarity::fitted(pulls.iter().map(|p| (rest[p.vertex as usize], p.target, p.weight)));
    led(elastic, rest, pulls, &fitted, || Ok(()))
}

/// As [`deformed`], the shape being scaled as by the similarity, from whose places it starts.
///
/// # Errors
/// As [`deformed`]; that of `ask`, which is asked in every round whether to go on.
pub fn led<E: From<FactorisationError>>(
    elastic: &Elastic,
    rest: &[[f64; 2]],
    pulls: &[Pull],
    similarity: &Similarity,
    ask: impl Fn() -> Result<(), E>,
) -> Result<Vec<[f64; 2]>, E> {
    let n = rest.len();
    let mut matrix = elastic.laplacian.clone();
    let mut hold = vec![0.0; n];
    let mut pull = vec![[0.0; 2]; n];
    for p in pulls {
        let v = p.vertex as usize;
        hold[v] += p.weight;
        pull[v][0] += p.weight * p.target[0];
        pull[v][1] += p.weight * p.target[1];
    }
    for (diagonal, hold) in matrix.diag_iter_mut().zip(&hold) {
        // A vertex of the shape has edges.
        *diagonal.expect("a Laplacian has a diagonal") += hold;
    }
    let factor = SparseCholesky::asking(elastic.analysis.clone(), matrix, &ask)??;
    let solve = |right: &dyn Fn(usize, usize) -> f64| {
        let mut block = Mat::from_fn(n, 2, right);
        factor.solve(block.as_mut());
        (0..n).map(|v| [block[(v, 0)], block[(v, 1)]]).collect::<Vec<[f64; 2]>>()
    };

    let placed: Vec<[f64; 2]> = rest.iter().map(|&p| similarity.apply(p)).collect();
    let rest: Vec<[f64; 2]> = rest.iter().map(|p| p.map(|x| x * similarity.scale)).collect();
    let correction = solve(&|v, axis| pull[v][axis] - hold[v] * placed[v][axis]);
    let mut now: Vec<[f64; 2]> = placed.iter().zip(&correction).map(|(p, c)| [p[0] + c[0], p[1] + c[1]]).collect();
    for _ in 0..ROUNDS {
        ask()?;
        let turns = rotations(elastic, &rest, &now);
        let mut right = pull.clone();
        for &(i, j, w) in &elastic.edges {
            let (i, j) = (i as usize, j as usize);
            let edge = [rest[i][0] - rest[j][0], rest[i][1] - rest[j][1]];
            let (c, s) = (turns[i][0] + turns[j][0], turns[i][1] + turns[j][1]);
            let force = [w * (c * edge[0] - s * edge[1]), w * (s * edge[0] + c * edge[1])];
            for axis in 0..2 {
                right[i][axis] += force[axis];
                right[j][axis] -= force[axis];
            }
        }
        now = solve(&|v, axis| right[v][axis]);
    }
    Ok(now)
}

/// The best rotation of every vertex's star as (cos, sin).
pub fn rotations(elastic: &Elastic, rest: &[[f64; 2]], now: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut turns = vec![[0.0; 2]; rest.len()];
    for &(i, j, w) in &elastic.edges {
        let (i, j) = (i as usize, j as usize);
        let e = [rest[i][0] - rest[j][0], rest[i][1] - rest[j][1]];
        let d = [now[i][0] - now[j][0], now[i][1] - now[j][1]];
        let (c, s) = (w * (e[0] * d[0] + e[1] * d[1]), w * (e[0] * d[1] - e[1] * d[0]));
        for v in [i, j] {
            turns[v][0] += c;
            turns[v][1] += s;
        }
    }
    for turn in &mut turns {
        let length = turn[0].hypot(turn[1]) + 1e-12;
        *turn = turn.map(|x| x / length);
    }
    turns
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::connectivity::boundary_vertices;
    use crate::mesh::solids::sheet;

    /// A shape at rest, and the vertices of its outline.
    fn shape() -> (Elastic, Vec<[f64; 2]>, Vec<u32>) {
        let mesh = sheet(12, 5);
        let rest = mesh.positions().iter().map(|&[x, y, _]| [x, y]).collect();
        let outline = boundary_vertices(&mesh);
        let outline = (0..).zip(outline).filter(|&(_, is_of_it)| is_of_it).map(|(v, _)| v).collect();
        (Elastic::new(&mesh).unwrap(), rest, outline)
    }

    #[test]
    fn pulls_of_a_similarity_move_the_whole_without_strain() {
        let (elastic, rest, outline) = shape();
        let (s, c) = 0.8f64.sin_cos();
        let place = |[x, y]: [f64; 2]| [1.7 * (c * x - s * y) + 0.3, 1.7 * (s * x + c * y) - 2.0];
        let pulls: Vec<Pull> =
            outline.iter().map(|&vertex| Pull { vertex, target: place(rest[vertex as usize]), weight: 0.5 }).collect();
        for (now, rest) in deformed(&elastic, &rest, &pulls).unwrap().iter().zip(&rest) {
            let expected = place(*rest);
            assert!((now[0] - expected[0]).hypot(now[1] - expected[1]) < 1e-9);
        }
    }

    #[test]
    fn a_strong_pull_is_followed_and_without_any_there_is_no_answer() {
        let (elastic, rest, outline) = shape();
        let mut pulls: Vec<Pull> =
            outline.iter().map(|&vertex| Pull { vertex, target: rest[vertex as usize], weight: 1e-3 }).collect();
        pulls[0].weight = 1e6;
        pulls[0].target[1] += 0.1;
        let now = deformed(&elastic, &rest, &pulls).unwrap()[pulls[0].vertex as usize];
        assert!((now[0] - pulls[0].target[0]).hypot(now[1] - pulls[0].target[1]) < 1e-4);
    }
}
