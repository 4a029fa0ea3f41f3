//! A surface of fewer triangles, its vertices among those it had: they leave to where a neighbour stands, those first that
//! change the surface least [GH97].

mod quadric;
mod stars;

use super::TriangleMesh;
use crate::geometry::{cross, dot, length, subtract};
use quadric::Quadric;
use stars::Stars;

/// Most triangles about a vertex that leaves, or that another one leaves to: bounds what is looked at.
const CROWD: usize = 24;
/// Least cosine of the angle by which a triangle may turn.
const TURNED: f64 = 0.2;
/// The weight of the planes that hold a boundary in its place, across the surface, beside that of the surface.
const BOUNDARY: f64 = 10.0;
/// The weight of the places of vertices beside that of the surface: where it is flat, triangles stay as even as they were.
const PLACES: f64 = 1e-3;
/// One in so many of the vertices that could leave does so in a round at most, the cheapest.
const ONE_IN: usize = 2;
/// Least share of the triangles that a round takes away for there to be another.
const WORTHWHILE: f64 = 1e-2;

/// A surface and what became of the vertices it was made of.
pub(super) struct Decimated {
    pub triangles: Vec<[u32; 3]>,
    /// Per vertex the one that stands for it: itself where it is still there.
    pub left_to: Vec<u32>,
}

/// A surface of at most so many triangles that hangs together as the mesh does, sound and with the same boundaries, made of
/// some of its vertices; nothing where it cannot be had. O(n log n).
pub(super) fn decimated(mesh: &TriangleMesh, most: usize) -> Option<Decimated> {
    let positions = at_unit_size(mesh.positions());
    let mut triangles = mesh.triangles().to_vec();
    let mut quadrics = quadrics(&positions, &triangles);
    let mut left_to: Vec<u32> = (0..positions.len() as u32).collect();
    while triangles.len() > most {
        let round = Round { positions: &positions, quadrics: &quadrics, stars: Stars::of(positions.len(), &triangles) };
        let leaving = round.leaving(triangles.len() - most);
        let before = triangles.len();
        for &Leaving { vertex, to, .. } in &leaving {
            left_to[vertex as usize] = to;
            let quadric = quadrics[vertex as usize];
            quadrics[to as usize] += quadric;
        }
        triangles.iter_mut().flatten().for_each(|v| *v = left_to[*v as usize]);
        triangles.retain(|&[a, b, c]| a != b && b != c && c != a);
        if triangles.len() > most && ((before - triangles.len()) as f64) < WORTHWHILE * before as f64 {
            return None;
        }
    }
    for v in 0..left_to.len() {
        while left_to[left_to[v] as usize] != left_to[v] {
            left_to[v] = left_to[left_to[v] as usize];
        }
    }
    Some(Decimated { triangles, left_to })
}

/// The positions from their middle, in units of their extent.
fn at_unit_size(positions: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let (low, high) = positions.iter().fold(([f64::INFINITY; 3], [f64::NEG_INFINITY; 3]), |(low, high), p| {
        ([0, 1, 2].map(|i: usize| p[i].min(low[i])), [0, 1, 2].map(|i: usize| p[i].max(high[i])))
    });
    let extent = subtract(high, low).into_iter().fold(f64::MIN_POSITIVE, f64::max);
    positions.iter().map(|p| [0, 1, 2].map(|i: usize| (p[i] - 0.5 * (low[i] + high[i])) / extent)).collect()
}

/// Per vertex what its triangles, its boundary and its place weigh.
fn quadrics(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> Vec<Quadric> {
    let mut quadrics = vec![Quadric::default(); positions.len()];
    let stars = Stars::of(positions.len(), triangles);
    for triangle in triangles {
        let [a, b, c] = triangle.map(|v| positions[v as usize]);
        let normal = cross(subtract(b, a), subtract(c, a));
        let doubled_area = length(normal);
        if doubled_area == 0.0 {
            continue;
        }
        let normal = normal.map(|x| x / doubled_area);
        for (corner, &v) in triangle.iter().enumerate() {
            let (p, next) = (positions[v as usize], triangle[(corner + 1) % 3]);
            quadrics[v as usize] += Quadric::of_plane(normal, a, doubled_area);
            quadrics[v as usize] += Quadric::of_point(p, PLACES * doubled_area);
            if !stars.sides(v).any(|[_, previous]| previous == next) {
                let along = subtract(positions[next as usize], p);
                let across = cross(along, normal).map(|x| x / length(along));
                let held = Quadric::of_plane(across, p, BOUNDARY * dot(along, along));
                [v, next].into_iter().for_each(|end| quadrics[end as usize] += held);
            }
        }
    }
    quadrics
}

/// A vertex that may leave to where a neighbour stands.
struct Leaving {
    vertex: u32,
    to: u32,
    cost: f64,
    triangles: usize,
}

/// A surface from which vertices are to leave.
struct Round<'a> {
    positions: &'a [[f64; 3]],
    quadrics: &'a [Quadric],
    stars: Stars<'a>,
}

impl Round<'_> {
    /// Vertices of which each may leave whatever the others do, the cheapest first, until so many triangles are gone.
    fn leaving(&self, excess: usize) -> Vec<Leaving> {
        let mut candidates: Vec<Leaving> = (0..self.positions.len() as u32).filter_map(|v| self.cheapest(v)).collect();
        candidates.sort_unstable_by(|a, b| a.cost.total_cmp(&b.cost).then(a.vertex.cmp(&b.vertex)));
        candidates.truncate(candidates.len().div_ceil(ONE_IN));
        let mut changed = vec![false; self.positions.len()];
        let mut gone = 0;
        candidates.retain(|&Leaving { vertex, to, triangles, .. }| {
            let leaves = gone < excess && !changed[vertex as usize] && !changed[to as usize];
            if leaves {
                gone += triangles;
                changed[vertex as usize] = true;
                self.stars.sides(vertex).flatten().for_each(|v| changed[v as usize] = true);
            }
            leaves
        });
        candidates
    }

    /// The neighbour to which a vertex may leave at the least cost.
    fn cheapest(&self, vertex: u32) -> Option<Leaving> {
        if !(1..=CROWD).contains(&self.stars.size(vertex)) {
            return None;
        }
        let mut best: Option<Leaving> = None;
        for to in self.stars.sides(vertex).flatten() {
            let mut quadric = self.quadrics[vertex as usize];
            quadric += self.quadrics[to as usize];
            let cost = quadric.at(self.positions[to as usize]);
            if best.as_ref().is_none_or(|best| cost < best.cost)
                && let Some(triangles) = self.triangles_lost(vertex, to)
            {
                best = Some(Leaving { vertex, to, cost, triangles });
            }
        }
        best
    }

    /// How many triangles vanish where a vertex leaves to a neighbour, one or two; none where the surface would not hang
    /// together as it does (the link condition [DEGN99]) or a triangle would turn over.
    fn triangles_lost(&self, vertex: u32, to: u32) -> Option<usize> {
        let sides = self.stars.sides(vertex);
        let at_edge = sides.clone().filter(|side| side.contains(&to)).count();
        let is_inner = sides.clone().all(|[next, _]| sides.clone().any(|[_, previous]| previous == next));
        let along_boundary = at_edge == 1 && self.stars.size(vertex) > 1;
        if !(is_inner || along_boundary) || self.stars.size(to) > CROWD {
            return None;
        }
        let others = self.stars.sides(to);
        let mut common: Vec<u32> =
            sides.clone().flatten().filter(|v| others.clone().any(|side| side.contains(v))).collect();
        common.sort_unstable();
        common.dedup();
        let mut stay = sides.filter(|side| !side.contains(&to));
        let fits = |[a, b]: [u32; 2]| {
            let repeats = others.clone().any(|side| side.contains(&a) && side.contains(&b));
            !repeats && self.keeps_its_side([vertex, a, b], to)
        };
        (common.len() == at_edge && stay.all(fits)).then_some(at_edge)
    }

    /// Whether a triangle faces as it did where its first corner moves to where `to` stands.
    fn keeps_its_side(&self, [first, a, b]: [u32; 3], to: u32) -> bool {
        let at = |v: u32| self.positions[v as usize];
        let normal = |first: u32| cross(subtract(at(a), at(first)), subtract(at(b), at(first)));
        let (before, after) = (normal(first), normal(to));
        length(before) == 0.0 || dot(before, after) > TURNED * length(before) * length(after)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::connectivity::components;
    use crate::mesh::edges::Edges;
    use crate::mesh::solids::{sphere, star};

    /// The mesh of the vertices that are left.
    fn coarse(mesh: &TriangleMesh, most: usize) -> TriangleMesh {
        let Decimated { triangles, left_to } = decimated(mesh, most).unwrap();
        assert!(triangles.as_flattened().iter().all(|&v| left_to[v as usize] == v));
        assert!(left_to.iter().all(|&v| left_to[v as usize] == v));
        TriangleMesh::new(mesh.positions().to_vec(), triangles).unwrap()
    }

    #[test]
    fn a_body_keeps_its_shape() {
        for mesh in [sphere(60, 120), star(0.02)] {
            let most = mesh.triangles().len() / 5;
            let coarse = coarse(&mesh, most);
            assert!((most - 2..=most).contains(&coarse.triangles().len()));
            assert_eq!(Edges::of(coarse.triangles()).boundary().count(), 0);
            assert!((coarse.area() / mesh.area() - 1.0).abs() < 0.01, "{} for {}", coarse.area(), mesh.area());
        }
    }

    #[test]
    fn a_sheet_keeps_its_corners_and_its_border() {
        let n = 40u32;
        let positions = (0..=n).flat_map(|y| (0..=n).map(move |x| [f64::from(x), f64::from(y), 0.0])).collect();
        let quads = (0..n).flat_map(|y| (0..n).map(move |x| y * (n + 1) + x));
        let triangles = quads.flat_map(|v| [[v, v + 1, v + n + 2], [v, v + n + 2, v + n + 1]]).collect();
        let sheet = TriangleMesh::new(positions, triangles).unwrap();
        let coarse = coarse(&sheet, 200);
        assert!((coarse.area() - 1600.0).abs() < 1e-9);
        assert_eq!(components(&coarse).list.len(), 1);
    }

    #[test]
    fn what_hangs_together_least_is_left_alone() {
        // Tetrahedra, and triangles by themselves, cannot do with fewer triangles.
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let positions = (0..10).flat_map(|i| corners.map(|p| [p[0] + 2.0 * f64::from(i), p[1], p[2]])).collect();
        let sides = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
        let triangles =
            (0..10).flat_map(|i| sides.into_iter().take(if i < 5 { 4 } else { 1 }).map(move |t| t.map(|v| v + 4 * i)));
        let mesh = TriangleMesh::new(positions, triangles.collect()).unwrap();
        assert!(decimated(&mesh, 24).is_none());
        assert_eq!(decimated(&mesh, 25).unwrap().triangles.len(), 25);
    }

    #[test]
    fn an_octahedron_becomes_a_tetrahedron_and_no_less() {
        let positions = [[1., 0., 0.], [-1., 0., 0.], [0., 1., 0.], [0., -1., 0.], [0., 0., 1.], [0., 0., -1.]];
        let faces = [[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
        let mesh = TriangleMesh::new(positions.to_vec(), faces.to_vec()).unwrap();
        assert!(decimated(&mesh, 3).is_none());
        assert!(coarse(&mesh, 6).triangles().len() <= 6);
    }
}
