//! A surface told by the lengths of its edges, triangulated anew where its triangles are thin [SC20].
//!
//! The operator of thin triangles drowns in rounding, and triangles without area have none. Lengths that just make no
//! triangle are made a little longer, all by the same; then the edges of thin triangles are flipped within the surface, and
//! from there those about them, until all are Delaunay: it stays what it is, and its vertices too. Elsewhere the triangles
//! stay as they are: a few slivers change the operator where they are, not the whole of it, which Delaunay edges would by
//! some hundredths on meshes that have others.

use super::laplacian::Triangles;
use crate::geometry::{doubled_area_of_sides, length, subtract};
use crate::mesh::TriangleMesh;
use crate::mesh::edges::{Edges, HalfEdge, triangle_of};
use crate::numerics::{Cancelled, Pace, Watch};

/// A triangle is thin where its height over its longest edge is less than this share of that edge.
const THIN: f64 = 1e-4;
/// By how much two edges of a triangle are longer together than the third, as a share of a short edge of the mesh.
const SLACK: f64 = 1e-5;
/// The share of edges that are shorter than what counts as a short edge.
const SHORTER: usize = 10;
/// The least sum of cotangents opposite an edge that is Delaunay but for rounding.
const DELAUNAY: f64 = -1e-9;
/// Flips for each edge, after which the triangulation is taken as it is. Sheared grids take about ten.
const PATIENCE: usize = 100;

/// Marks a half-edge on the boundary.
const ALONE: HalfEdge = HalfEdge::MAX;

/// Where triangles are so thin that an operator is to be made from others, the surface with Delaunay edges in their place;
/// its vertices are those of the mesh.
///
/// # Errors
/// [`Cancelled`] by the watcher, asked as edges are flipped.
pub(super) fn without_thin(mesh: &TriangleMesh, watch: &dyn Watch) -> Result<Option<Triangles>, Cancelled> {
    let thin: Vec<usize> = lengths(mesh).into_iter().enumerate().filter(|(_, l)| is_thin(*l)).map(|(t, _)| t).collect();
    if thin.is_empty() {
        return Ok(None);
    }
    let mut surface = Surface::of(mesh);
    surface.mollify();
    surface.flip(&thin, watch)?;
    Ok(Some(Triangles { corners: surface.corners, lengths: surface.lengths }))
}

fn is_thin(lengths: [f64; 3]) -> bool {
    let (longest, area) = (lengths.into_iter().fold(0.0, f64::max), doubled_area_of_sides(lengths));
    // Not a number where rounding leaves no triangle.
    area.is_nan() || area <= THIN * longest * longest
}

/// Of every triangle the lengths of its sides, the first from its first corner to its second.
fn lengths(mesh: &TriangleMesh) -> Vec<[f64; 3]> {
    let side = |a: u32, b: u32| length(subtract(mesh.positions()[b as usize], mesh.positions()[a as usize]));
    mesh.triangles().iter().map(|&[a, b, c]| [side(a, b), side(b, c), side(c, a)]).collect()
}

/// Triangles glued along their sides; vertices may be joined by several edges, and by an edge with themselves.
struct Surface {
    corners: Vec<[u32; 3]>,
    lengths: Vec<[f64; 3]>,
    /// Per half-edge the other one on its edge, or [`ALONE`].
    partners: Vec<HalfEdge>,
}

impl Surface {
    fn of(mesh: &TriangleMesh) -> Surface {
        let mut partners = vec![ALONE; 3 * mesh.triangles().len()];
        for [g, h] in Edges::of(mesh.triangles()).pairs() {
            partners[g as usize] = h;
            partners[h as usize] = g;
        }
        Surface { corners: mesh.triangles().to_vec(), lengths: lengths(mesh), partners }
    }

    /// Makes all edges longer by as much as the flattest triangle needs to be one.
    fn mollify(&mut self) {
        let mut positive: Vec<f64> = self.lengths.as_flattened().iter().copied().filter(|&l| l > 0.0).collect();
        let rank = positive.len() / SHORTER;
        let short = if positive.is_empty() { 1.0 } else { *positive.select_nth_unstable_by(rank, f64::total_cmp).1 };
        let lacking = |&[a, b, c]: &[f64; 3]| {
            SLACK * short - [a + b - c, b + c - a, c + a - b].into_iter().fold(f64::INFINITY, f64::min)
        };
        let longer = self.lengths.iter().map(lacking).fold(0.0, f64::max);
        self.lengths.as_flattened_mut().iter_mut().for_each(|length| *length += longer);
    }

    /// Flips edges until those of these triangles, and of all that are changed for them, are Delaunay.
    fn flip(&mut self, thin: &[usize], watch: &dyn Watch) -> Result<(), Cancelled> {
        let sides = thin.iter().flat_map(|&t| (3 * t as HalfEdge..).take(3));
        let mut pending: Vec<HalfEdge> = sides.map(|h| h.min(self.partner(h))).collect();
        pending.sort_unstable();
        pending.dedup();
        let mut is_pending = vec![false; self.partners.len()];
        pending.iter().for_each(|&h| is_pending[h as usize] = true);
        let mut patience = PATIENCE * self.partners.len();
        let mut pace = Pace::new(watch, patience);
        while let Some(h) = pending.pop().filter(|_| patience > 0) {
            pace.step()?;
            is_pending[h as usize] = false;
            let g = self.partner(h);
            if g == ALONE || triangle_of(g) == triangle_of(h) || self.cotangent(h) + self.cotangent(g) >= DELAUNAY {
                continue;
            }
            patience -= 1;
            for side in self.flipped(h, g) {
                let partner = self.partner(side);
                let known = is_pending[side as usize] || partner != ALONE && is_pending[partner as usize];
                if partner != ALONE && !known {
                    is_pending[side as usize] = true;
                    pending.push(side);
                }
            }
        }
        Ok(())
    }

    fn partner(&self, h: HalfEdge) -> HalfEdge {
        self.partners[h as usize]
    }

    fn side(&self, h: HalfEdge) -> f64 {
        self.lengths[triangle_of(h)][h as usize % 3]
    }

    /// The cotangent of the angle opposite a half-edge.
    fn cotangent(&self, h: HalfEdge) -> f64 {
        let [a, b, c] = sides_from(h).map(|side| self.side(side));
        (b * b + c * c - a * a) / (2.0 * doubled_area_of_sides([a, b, c]))
    }

    /// Replaces the edge of two half-edges by the other diagonal of its quadrilateral; the four sides of that.
    fn flipped(&mut self, h: HalfEdge, g: HalfEdge) -> [HalfEdge; 4] {
        // h runs from i to j with k opposite, g from j to i with m opposite.
        let ([h, jk, ki], [g, im, mj]) = (sides_from(h), sides_from(g));
        let corner = |side: HalfEdge| self.corners[triangle_of(side)][side as usize % 3];
        let (i, j, k, m) = (corner(h), corner(g), corner(ki), corner(mj));
        let apex = |to_start: f64, to_end: f64| {
            let base = self.side(h);
            let x = (to_start * to_start - to_end * to_end + base * base) / (2.0 * base);
            (x, doubled_area_of_sides([base, to_start, to_end]) / base)
        };
        let ((kx, ky), (mx, my)) = (apex(self.side(ki), self.side(jk)), apex(self.side(im), self.side(mj)));
        let across = (kx - mx).hypot(ky + my);
        let outer = [im, ki, jk, mj];
        let (lengths, partners) = (outer.map(|side| self.side(side)), outer.map(|side| self.partner(side)));
        let (t, u) = (triangle_of(h), triangle_of(g));
        self.corners[t] = [i, m, k];
        self.corners[u] = [j, k, m];
        self.lengths[t] = [lengths[0], across, lengths[1]];
        self.lengths[u] = [lengths[2], across, lengths[3]];
        let (t, u) = (3 * t as HalfEdge, 3 * u as HalfEdge);
        let moved = [t, t + 2, u, u + 2];
        for (new, old) in moved.into_iter().zip(partners) {
            // A partner that was one of the four has moved as well.
            let partner = outer.iter().position(|&side| side == old).map_or(old, |place| moved[place]);
            self.partners[new as usize] = partner;
            if partner != ALONE {
                self.partners[partner as usize] = new;
            }
        }
        self.partners[t as usize + 1] = u + 1;
        self.partners[u as usize + 1] = t + 1;
        moved
    }
}

/// The half-edges of a triangle from this one on.
fn sides_from(h: HalfEdge) -> [HalfEdge; 3] {
    let first = h - h % 3;
    [h, first + (h % 3 + 1) % 3, first + (h % 3 + 2) % 3]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::solids::ball;
    use crate::numerics::Unwatched;
    use crate::spectral::laplacian::Lumping;
    use crate::spectral::{Boundary, spectrum_with};

    /// A long body of which many edges are not Delaunay.
    fn long() -> TriangleMesh {
        ball(24, 48, |[x, y, z]| [4.0 * x, y, z])
    }

    /// The same with corners on the middles of some edges, and triangles without area that fill the cracks.
    fn with_slivers(mesh: &TriangleMesh, every: usize) -> TriangleMesh {
        let (mut positions, mut triangles) = (mesh.positions().to_vec(), mesh.triangles().to_vec());
        for t in (0..mesh.triangles().len()).step_by(every) {
            let [a, b, c] = triangles[t];
            let middle = positions.len() as u32;
            let [p, q] = [a, b].map(|v| positions[v as usize]);
            positions.push([0, 1, 2].map(|i| 0.5 * (p[i] + q[i])));
            triangles[t] = [a, middle, c];
            triangles.extend([[middle, b, c], [a, b, middle]]);
        }
        TriangleMesh::new(positions, triangles).unwrap()
    }

    #[test]
    fn a_few_slivers_change_an_operator_where_they_are() {
        let eigenvalues = |mesh: &TriangleMesh| {
            spectrum_with(mesh, Lumping::Mixed, 20, Boundary::Neumann, &Unwatched).unwrap().eigenvalues
        };
        let mesh = long();
        assert_eq!(without_thin(&mesh, &Unwatched).map(|thin| thin.is_some()), Ok(false));
        let (sound, broken) = (eigenvalues(&mesh), eigenvalues(&with_slivers(&mesh, 100)));
        for (sound, broken) in sound.iter().zip(broken).skip(1) {
            assert!((broken / sound - 1.0).abs() < 2e-3, "{broken} for {sound}");
        }
    }

    #[test]
    fn no_thin_triangle_is_left_and_the_area_stays() {
        let mesh = with_slivers(&long(), 7);
        let Triangles { lengths, .. } = without_thin(&mesh, &Unwatched).unwrap().unwrap();
        assert!(!lengths.iter().any(|&lengths| is_thin(lengths)));
        let area: f64 = lengths.iter().map(|&lengths| 0.5 * doubled_area_of_sides(lengths)).sum();
        assert!((area / mesh.area() - 1.0).abs() < 1e-3, "{area}");
    }
}
