//! Deformation transfer [SP04] from a flat drawing to a surface that is seen as the drawing is.
//!
//! In the plane of the picture a triangle s of the drawing is deformed by a 2 × 2 matrix S_s; along the line of sight
//! nothing is. The correspondence M of triangles (eq. 5.3) is many-to-many and weighted: a triangle of the surface follows
//! the mean S of the drawing's triangles around the vertices that are answered near it, and where nothing is answered, on
//! the side away from the viewer and on what the drawing does not show, S goes on as smoothly as may be. The places of the
//! surface are then those whose gradients are nearest to S (eq. 5.5), vertices being shared by their triangles (eq. 5.4):
//! in terms of cotangents, a Poisson problem [BSPG06]. Both systems are factorised once.

use faer::Mat;

use super::links::{Link, joined, laplacian};
use crate::geometry::doubled_area;
use crate::mesh::TriangleMesh;
use crate::numerics::cholesky::{Analysis, FactorisationError, SparseCholesky};
use crate::spectral::laplacian::{Lumping, mass};

/// How strongly S holds to the drawing where it is answered, beside its smoothness, at area 1: answers nearer than about
/// 0.04 √area are blended.
const FAITH: f64 = 500.0;
/// How strongly places hold to the drawing's, beside their gradients. It is to tell where the surface is, not how it bends.
const HOLD: f64 = 1e-2;

/// Functions carried over at a time.
const AT_A_TIME: usize = 4;

/// A vertex of a drawing and the vertex of a surface it is, with its weight above 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pair {
    pub drawing: u32,
    pub surface: u32,
    pub weight: f64,
}

/// b functions on a surface of n vertices.
pub struct Carried {
    /// n × b.
    pub values: Mat<f64>,
    /// S: n × 2 b, of each function along x and along y in the plane of the drawing.
    pub gradients: Mat<f64>,
}

impl Carried {
    /// The value of a function beside a vertex of the surface, so far from it in the plane of the drawing.
    pub fn beside(&self, vertex: usize, [x, y]: [f64; 2], function: usize) -> f64 {
        let along = |axis: usize| self.gradients[(vertex, 2 * function + axis)];
        self.values[(vertex, function)] + x * along(0) + y * along(1)
    }
}

/// Takes functions of a drawing's m vertices to a surface's n: linear, and exact for those that are linear in the plane.
pub struct Transfer<'a> {
    drawing: &'a TriangleMesh,
    /// Of the surface, in the plane of the drawing.
    places: &'a [[f64; 2]],
    pairs: Vec<Pair>,
    links: Vec<Link>,
    smooth: SparseCholesky,
    placing: SparseCholesky,
}

impl<'a> Transfer<'a> {
    /// The transfer from a drawing to a surface whose vertices lie at `places` in the drawing's plane, by at least one
    /// pair.
    ///
    /// # Errors
    /// [`FactorisationError`] where memory runs out, or there is no pair; that of `ask`, which is asked whether to go on.
    pub fn new<E: From<FactorisationError>>(
        drawing: &'a TriangleMesh,
        surface: &TriangleMesh,
        places: &'a [[f64; 2]],
        pairs: &[Pair],
        ask: impl Fn() -> Result<(), E>,
    ) -> Result<Transfer<'a>, E> {
        let reached: Vec<u32> = pairs.iter().map(|pair| pair.surface).collect();
        let links = joined(surface, &reached);
        // Every pair stands for its part of the drawing.
        let masses = mass(drawing, Lumping::Barycentric);
        let weigh = |pair: &Pair| Pair { weight: pair.weight * masses[pair.drawing as usize], ..*pair };
        let mut pairs: Vec<Pair> = pairs.iter().map(weigh).collect();
        let total: f64 = pairs.iter().map(|pair| pair.weight).sum();
        pairs.iter_mut().for_each(|pair| pair.weight /= total);
        let matrix = laplacian(&links, places.len());
        let analysis = Analysis::asking(&matrix, &ask)??;
        let held = |strength: f64| {
            let mut hold = vec![0.0; places.len()];
            pairs.iter().for_each(|pair| hold[pair.surface as usize] += strength * pair.weight);
            let mut matrix = matrix.clone();
            for (diagonal, hold) in matrix.diag_iter_mut().zip(hold) {
                if let Some(diagonal) = diagonal {
                    *diagonal += hold;
                }
            }
            Ok::<_, E>(SparseCholesky::asking(analysis.clone(), matrix, &ask)??)
        };
        let (smooth, placing) = (held(FAITH)?, held(HOLD)?);
        Ok(Transfer { drawing, places, pairs, links, smooth, placing })
    }

    /// Functions of the drawing's vertices (m × b) on the surface.
    ///
    /// # Errors
    /// That of `ask`, which is asked at every few functions whether to go on.
    pub fn carried<E>(&self, functions: &Mat<f64>, ask: impl Fn() -> Result<(), E>) -> Result<Carried, E> {
        let (n, b) = (self.places.len(), functions.ncols());
        let mut carried = Carried { values: Mat::zeros(n, b), gradients: Mat::zeros(n, 2 * b) };
        for first in (0..b).step_by(AT_A_TIME) {
            ask()?;
            let count = AT_A_TIME.min(b - first);
            let some = self.carried_together(&functions.subcols(first, count).to_owned());
            carried.values.subcols_mut(first, count).copy_from(&some.values);
            carried.gradients.subcols_mut(2 * first, 2 * count).copy_from(&some.gradients);
        }
        Ok(carried)
    }

    fn carried_together(&self, f: &Mat<f64>) -> Carried {
        let (n, b) = (self.places.len(), f.ncols());
        let own = gradients(self.drawing, f);
        let mut gradients = Mat::<f64>::zeros(n, 2 * b);
        for pair in &self.pairs {
            for column in 0..2 * b {
                gradients[(pair.surface as usize, column)] +=
                    FAITH * pair.weight * own[(pair.drawing as usize, column)];
            }
        }
        self.smooth.solve(gradients.as_mut());
        let mut right = Mat::<f64>::zeros(n, b);
        for &(i, j, weight) in &self.links {
            let (i, j) = (i as usize, j as usize);
            let [x, y] = [0, 1].map(|axis| 0.5 * weight * (self.places[j][axis] - self.places[i][axis]));
            for column in 0..b {
                let sum = |part: usize| gradients[(i, 2 * column + part)] + gradients[(j, 2 * column + part)];
                let difference = x * sum(0) + y * sum(1);
                right[(j, column)] += difference;
                right[(i, column)] -= difference;
            }
        }
        for pair in &self.pairs {
            let (v, [x, y, _]) = (pair.drawing as usize, self.drawing.positions()[pair.drawing as usize]);
            let [u, w] = self.places[pair.surface as usize];
            for column in 0..b {
                // Where the surface lies beside the point it answers, it goes along with it.
                let there = f[(v, column)] + (u - x) * own[(v, 2 * column)] + (w - y) * own[(v, 2 * column + 1)];
                right[(pair.surface as usize, column)] += HOLD * pair.weight * there;
            }
        }
        self.placing.solve(right.as_mut());
        Carried { values: right, gradients }
    }
}

/// The gradients of functions (m × b) of a flat mesh at its vertices (m × 2b): the mean of those of its triangles,
/// weighted by area.
fn gradients(mesh: &TriangleMesh, functions: &Mat<f64>) -> Mat<f64> {
    let (m, b) = (functions.nrows(), functions.ncols());
    let mut sums = Mat::<f64>::zeros(m, 2 * b);
    let mut areas = vec![0.0; m];
    for triangle in mesh.triangles() {
        let corners = triangle.map(|v| mesh.positions()[v as usize]).map(|[x, y, _]| [x, y]);
        let doubled = doubled_area(corners);
        // Twice the area times the gradient of the function that is 1 at a corner is the side opposite, turned.
        let sides = [0, 1, 2].map(|c: usize| {
            let (p, q) = (corners[(c + 1) % 3], corners[(c + 2) % 3]);
            [p[1] - q[1], q[0] - p[0]]
        });
        for &v in triangle {
            areas[v as usize] += doubled;
            for (side, &corner) in sides.iter().zip(triangle) {
                for column in 0..2 * b {
                    sums[(v as usize, column)] += side[column % 2] * functions[(corner as usize, column / 2)];
                }
            }
        }
    }
    Mat::from_fn(m, 2 * b, |v, column| sums[(v, column)] / areas[v])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::solids::{ball, sheet};

    /// An ellipsoid that fills the sheet it is drawn on, about, and a part that floats beside it.
    fn body() -> TriangleMesh {
        let body = ball(20, 40, |[x, y, z]| [2.0 * x, y, z]);
        let n = body.positions().len() as u32;
        let scale = 0.2;
        let beside = body.positions().iter().map(|p| p.map(|x| scale * x + 0.9));
        let positions = body.positions().iter().copied().chain(beside).collect();
        let triangles = body.triangles().iter().copied().chain(body.triangles().iter().map(|t| t.map(|v| v + n)));
        TriangleMesh::new(positions, triangles.collect()).unwrap()
    }

    struct Setting {
        drawing: TriangleMesh,
        surface: TriangleMesh,
        places: Vec<[f64; 2]>,
        pairs: Vec<Pair>,
    }

    fn setting() -> Setting {
        let (drawing, surface) = (sheet(16, 8), body());
        let places: Vec<[f64; 2]> = surface.positions().iter().map(|&[x, y, _]| [x + 0.7, y + 0.35]).collect();
        let pairs = drawing.positions().iter().zip(0..).map(|(p, v)| {
            let squared = |q: &[f64; 2]| (q[0] - p[0]).powi(2) + (q[1] - p[1]).powi(2);
            let seen = (0..20 * 40u32).filter(|&s| surface.positions()[s as usize][2] > 0.0 && s < 700);
            let nearest = seen.min_by(|&a, &b| squared(&places[a as usize]).total_cmp(&squared(&places[b as usize])));
            Pair { drawing: v, surface: nearest.unwrap(), weight: 1.0 }
        });
        let pairs = pairs.collect();
        Setting { drawing, surface, places, pairs }
    }

    fn carried(setting: &Setting, function: impl Fn([f64; 2]) -> f64) -> Vec<f64> {
        let ask = || Ok::<_, FactorisationError>(());
        let transfer = Transfer::new(&setting.drawing, &setting.surface, &setting.places, &setting.pairs, ask).unwrap();
        let points = setting.drawing.positions();
        let f = Mat::from_fn(points.len(), 1, |v, _| function([points[v][0], points[v][1]]));
        transfer.carried(&f, ask).unwrap().values.col(0).iter().copied().collect()
    }

    #[test]
    fn what_is_linear_in_the_plane_is_carried_exactly() {
        let setting = setting();
        for [a, b, c] in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.8, -0.6, 3.0]] {
            let found = carried(&setting, |[x, y]| a * x + b * y + c);
            for (found, [x, y]) in found.iter().zip(&setting.places) {
                assert!((found - (a * x + b * y + c)).abs() < 1e-9, "{found}");
            }
        }
    }

    #[test]
    fn nothing_is_carried_as_nothing_and_sums_as_sums() {
        let setting = setting();
        assert!(carried(&setting, |_| 0.0).iter().all(|&x| x == 0.0));
        let (f, g) = (|[x, y]: [f64; 2]| x * x - y, |[x, y]: [f64; 2]| (3.0 * x * y).sin());
        let sum = carried(&setting, |p| 2.0 * f(p) + g(p));
        for ((sum, f), g) in sum.iter().zip(carried(&setting, f)).zip(carried(&setting, g)) {
            assert!((sum - 2.0 * f - g).abs() < 1e-9);
        }
    }

    #[test]
    fn a_bend_reaches_both_sides_of_the_surface_alike() {
        let setting = setting();
        let found = carried(&setting, |[x, _]| (x - 0.7).max(0.0).powi(2));
        for (v, [x, y, z]) in setting.surface.positions().iter().enumerate().take(700) {
            let expected = (x.max(0.0)).powi(2);
            assert!((found[v] - expected).abs() < 0.05, "{} for {expected} at {x} {y} {z}", found[v]);
        }
    }

    #[test]
    fn gradients_are_exact_for_linear_functions() {
        let mesh = sheet(5, 3);
        let f = Mat::from_fn(mesh.positions().len(), 2, |v, column| {
            let [x, y, _] = mesh.positions()[v];
            if column == 0 { 3.0 * x - y } else { 0.5 * y + 7.0 }
        });
        let found = gradients(&mesh, &f);
        for v in 0..found.nrows() {
            for (column, expected) in [3.0, -1.0, 0.0, 0.5].into_iter().enumerate() {
                assert!((found[(v, column)] - expected).abs() < 1e-12);
            }
        }
    }
}
