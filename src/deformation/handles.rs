//! Handles that a drawing is moved by, and the vertices they hold.

use std::collections::BTreeMap;

use kd_tree::KdIndexTree;

use super::domain::{domain, is_within, mean_edge};
use crate::geometry::doubled_area;
use crate::mesh::TriangleMesh;
use crate::mesh::flat::{nearest, reach};

/// Points looked at along a bone per mean edge of the drawing.
const PER_EDGE: f64 = 3.0;

/// How far from the line between two corners of a cage a vertex is on it, as a share of the line.
const ON_LINE: f64 = 1e-9;

/// Something by which a drawing is moved, at points of the plane of its mesh.
#[derive(Clone, Debug, PartialEq)]
pub enum Handle {
    /// Moves what is around it.
    Point([f64; 2]),
    /// Moves what is around the line between two points.
    Bone([[f64; 2]; 2]),
    /// A closed polygon, each corner of which moves by itself and the lines between them along.
    Cage(Vec<[f64; 2]>),
}

impl Handle {
    /// How many weights every place has because of it, each with a map of its own.
    pub fn functions(&self) -> usize {
        match self {
            Handle::Point(_) | Handle::Bone(_) => 1,
            Handle::Cage(points) => points.len(),
        }
    }
}

/// A handle that does not fit the drawing, and where: a member of it, such as `at` or `points/3`, or none for the whole.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Misplaced {
    pub handle: usize,
    pub member: String,
    pub detail: String,
}

/// The union of a drawing and its cages as a flat mesh, whose first vertices are those of the drawing, and the weights
/// that handles prescribe.
pub struct Held {
    pub mesh: TriangleMesh,
    /// Vertices of the drawing.
    pub drawing: usize,
    /// How many weights every vertex has.
    pub functions: usize,
    /// For a vertex that is held the weights that are not 0.
    pub values: BTreeMap<u32, Vec<(usize, f64)>>,
}

impl Held {
    /// A hash of all that the weights depend on.
    pub fn content_hash(&self) -> blake3::Hash {
        let mut hasher = blake3::Hasher::new();
        let mut number = |bytes: &[u8]| {
            hasher.update(bytes);
        };
        number(self.mesh.content_hash().as_bytes());
        [self.drawing, self.functions].iter().for_each(|count| number(&(*count as u64).to_le_bytes()));
        for (vertex, values) in &self.values {
            number(&vertex.to_le_bytes());
            number(&(values.len() as u64).to_le_bytes());
            for (function, weight) in values {
                number(&(*function as u64).to_le_bytes());
                number(&weight.to_le_bytes());
            }
        }
        hasher.finalize()
    }

    /// What the handles hold of a flat mesh: a point the nearest vertex, a bone those nearest to its points, a cage the
    /// vertices on its lines.
    ///
    /// # Errors
    /// Every handle that is off the drawing, crosses itself, or holds what another one holds already.
    pub fn new(mesh: &TriangleMesh, handles: &[Handle]) -> Result<Held, Vec<Misplaced>> {
        let mut faults = Faults(Vec::new());
        for (i, handle) in handles.iter().enumerate() {
            match handle {
                Handle::Point(at) => faults.unless_on(mesh, i, "at", *at),
                Handle::Bone([from, to]) => {
                    faults.unless_on(mesh, i, "from", *from);
                    faults.unless_on(mesh, i, "to", *to);
                }
                Handle::Cage(points) => faults.of_cage(mesh, i, points),
            }
        }
        faults.none()?;
        let cages: Vec<&[[f64; 2]]> = handles.iter().filter_map(cage).collect();
        let whole = domain(mesh, &cages).map_err(|detail| {
            let cage = handles.iter().position(|handle| cage(handle).is_some()).unwrap_or(0);
            vec![Misplaced { handle: cage, member: "points".to_owned(), detail }]
        })?;
        let drawn: Vec<[f64; 2]> = mesh.positions().iter().map(|&[x, y, _]| [x, y]).collect();
        let tree = KdIndexTree::build_by_ordered_float(&drawn);
        let mut held = Held { drawing: mesh.positions().len(), mesh: whole, functions: 0, values: BTreeMap::new() };
        let mut holders = BTreeMap::new();
        for (i, handle) in handles.iter().enumerate() {
            for (vertex, values) in held.by(&tree, mean_edge(mesh), handle) {
                if let Some(&other) = holders.get(&vertex) {
                    let detail = format!("it lies where handle {other} does, as far as the drawing's triangles tell");
                    faults.add(i, "", detail);
                    break;
                }
                holders.insert(vertex, i);
                held.values.insert(vertex, values);
            }
            held.functions += handle.functions();
        }
        faults.none().map(|()| held)
    }

    /// The vertices that a handle holds, in ascending order, and their weights, by the vertices of a drawing of this mean
    /// edge.
    fn by(&self, drawn: &KdIndexTree<'_, [f64; 2]>, edge: f64, handle: &Handle) -> BTreeMap<u32, Vec<(usize, f64)>> {
        let own = self.functions;
        let nearest = |point| drawn.nearest(&point).map(|found| (*found.item as u32, vec![(own, 1.0)]));
        match handle {
            Handle::Point(at) => nearest(*at).into_iter().collect(),
            Handle::Bone(ends) => samples(*ends, edge).filter_map(nearest).collect(),
            Handle::Cage(points) => {
                let lines = (0..points.len()).map(|i| (i, (i + 1) % points.len()));
                let mut held = BTreeMap::new();
                for (i, next) in lines {
                    for (vertex, &[x, y, _]) in self.mesh.positions().iter().enumerate() {
                        let Some(share) = along([x, y], [points[i], points[next]]) else { continue };
                        let values = [(own + i, 1.0 - share), (own + next, share)];
                        let some = values.into_iter().filter(|&(_, weight)| weight > 0.0).collect();
                        held.entry(vertex as u32).or_insert(some);
                    }
                }
                held
            }
        }
    }
}

fn cage(handle: &Handle) -> Option<&[[f64; 2]]> {
    match handle {
        Handle::Cage(points) => Some(points),
        Handle::Point(_) | Handle::Bone(_) => None,
    }
}

/// Points along a bone, closer to each other than vertices of this mean edge are.
fn samples([from, to]: [[f64; 2]; 2], edge: f64) -> impl Iterator<Item = [f64; 2]> {
    let count = (PER_EDGE * (to[0] - from[0]).hypot(to[1] - from[1]) / edge).ceil().clamp(1.0, 1e5) as usize;
    (0..=count).map(move |i| {
        let share = i as f64 / count as f64;
        [0, 1].map(|axis| (1.0 - share) * from[axis] + share * to[axis])
    })
}

/// Which share of a line lies before a point of it; nothing where it is none of it.
fn along(point: [f64; 2], [a, b]: [[f64; 2]; 2]) -> Option<f64> {
    let ([x, y], [u, v]) = ([point[0] - a[0], point[1] - a[1]], [b[0] - a[0], b[1] - a[1]]);
    let squared = u * u + v * v;
    let (share, off) = ((x * u + y * v) / squared, (x * v - y * u).abs() / squared);
    let near = |end: f64| (share - end).abs() <= ON_LINE;
    match share {
        _ if off > ON_LINE => None,
        _ if near(0.0) => Some(0.0),
        _ if near(1.0) => Some(1.0),
        share => (0.0..=1.0).contains(&share).then_some(share),
    }
}

struct Faults(Vec<Misplaced>);

impl Faults {
    fn add(&mut self, handle: usize, member: impl Into<String>, detail: impl Into<String>) {
        self.0.push(Misplaced { handle, member: member.into(), detail: detail.into() });
    }

    fn none(&mut self) -> Result<(), Vec<Misplaced>> {
        if self.0.is_empty() { Ok(()) } else { Err(std::mem::take(&mut self.0)) }
    }

    fn unless_on(&mut self, mesh: &TriangleMesh, handle: usize, member: &str, point: [f64; 2]) {
        let reach = reach(mesh);
        if nearest(mesh, point).is_none_or(|(_, distance)| distance.is_nan() || distance > reach) {
            self.add(handle, member, "it is not on the drawing");
        }
    }

    fn of_cage(&mut self, mesh: &TriangleMesh, handle: usize, points: &[[f64; 2]]) {
        if !points.iter().flatten().all(|x| x.is_finite()) {
            return self.add(handle, "points", "a coordinate is not a finite number");
        }
        if let Some([i, j]) = crossing(points) {
            let detail = format!("the line from this corner meets that from corner {j}: a cage does not cross itself");
            return self.add(handle, format!("points/{i}"), detail);
        }
        let encloses = |&[x, y, _]: &[f64; 3]| is_within(points, [x, y]);
        if !mesh.positions().iter().any(encloses) {
            self.add(handle, "points", "the cage encloses nothing of the drawing");
        }
    }
}

/// The first two lines of a closed polygon that share more than the corner between them, by the corners they begin at.
fn crossing(points: &[[f64; 2]]) -> Option<[usize; 2]> {
    let n = points.len();
    let line = |i: usize| [points[i], points[(i + 1) % n]];
    let pairs = (0..n).flat_map(|i| (i + 1..n).map(move |j| [i, j]));
    let mut crossing = pairs.filter(|&[i, j]| {
        let ([a, b], [c, d]) = (line(i), line(j));
        if j == i + 1 || (i == 0 && j == n - 1) {
            // Neighbours: only one that goes back on the other shares more.
            let (corner, before, after) = if j == i + 1 { (b, a, d) } else { (a, b, c) };
            let [u, v] = [before, after].map(|p| [p[0] - corner[0], p[1] - corner[1]]);
            return doubled_area([corner, before, after]) == 0.0 && u[0] * v[0] + u[1] * v[1] >= 0.0;
        }
        let side = |p, q, r| doubled_area([p, q, r]);
        let straddle = |p: f64, q: f64| (p <= 0.0 && q >= 0.0) || (p >= 0.0 && q <= 0.0);
        let overlap =
            |axis: usize| a[axis].min(b[axis]) <= c[axis].max(d[axis]) && c[axis].min(d[axis]) <= a[axis].max(b[axis]);
        straddle(side(a, b, c), side(a, b, d)) && straddle(side(c, d, a), side(c, d, b)) && overlap(0) && overlap(1)
    });
    crossing.next()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::solids::sheet;

    fn refused(handles: &[Handle]) -> Vec<(usize, String)> {
        let faults = Held::new(&sheet(8, 4), handles).err().unwrap_or_default();
        faults.into_iter().map(|fault| (fault.handle, fault.member)).collect()
    }

    fn cage(points: &[[f64; 2]]) -> Handle {
        Handle::Cage(points.to_vec())
    }

    #[test]
    fn handles_hold_the_vertices_nearest_to_them() {
        let mesh = sheet(8, 4);
        let at = |v: usize| [mesh.positions()[v][0], mesh.positions()[v][1]];
        let held = Held::new(&mesh, &[Handle::Point(at(3)), Handle::Bone([at(18), at(26)])]).unwrap();
        let vertices: Vec<u32> = held.values.keys().copied().collect();
        assert_eq!(vertices, [3, 18, 19, 20, 21, 22, 23, 24, 25, 26]);
        assert_eq!((held.values[&3].as_slice(), held.values[&20].as_slice()), (&[(0, 1.0)][..], &[(1, 1.0)][..]));
    }

    #[test]
    fn along_a_cage_weights_are_linear() {
        let corners = [[-0.2, -0.2], [1.7, -0.2], [1.7, 1.0], [-0.2, 1.0]];
        let held = Held::new(&sheet(8, 4), &[Handle::Point([0.5, 0.3]), cage(&corners)]).unwrap();
        assert_eq!(held.functions, 5);
        assert!(held.mesh.positions().len() > held.drawing + 10);
        let mut found = 0;
        for (&vertex, values) in held.values.iter().filter(|(vertex, _)| **vertex as usize >= held.drawing) {
            let place = |axis: usize| values.iter().map(|&(f, w)| w * corners[f - 1][axis]).sum::<f64>();
            let [x, y, _] = held.mesh.positions()[vertex as usize];
            assert!((place(0) - x).hypot(place(1) - y) < 1e-9);
            found += 1;
        }
        assert!(found > 10);
    }

    #[test]
    fn what_does_not_fit_is_named() {
        assert_eq!(refused(&[Handle::Point([9.0, 0.0])]), [(0, "at".to_owned())]);
        assert_eq!(refused(&[Handle::Point([f64::NAN, 0.0])]), [(0, "at".to_owned())]);
        let twice = [Handle::Point([0.4, 0.3]), Handle::Point([0.41, 0.3])];
        assert_eq!(refused(&twice), [(1, String::new())]);
        assert_eq!(refused(&[Handle::Bone([[0.1, 0.1], [0.1, 7.0]])]), [(0, "to".to_owned())]);
        assert_eq!(refused(&[cage(&[[0., 0.], [1., 1.], [1., 0.], [0., 1.]])]), [(0, "points/0".to_owned())]);
        assert_eq!(refused(&[cage(&[[0., 0.], [1., 0.], [0.5, 0.]])])[0].1, "points/0");
        assert_eq!(refused(&[cage(&[[5., 5.], [6., 5.], [6., 6.]])]), [(0, "points".to_owned())]);
    }

    #[test]
    fn a_polygon_that_crosses_itself_is_found() {
        assert_eq!(crossing(&[[0., 0.], [2., 0.], [2., 2.], [0., 2.]]), None);
        assert_eq!(crossing(&[[0., 0.], [2., 0.], [1., 1.], [1., 3.]]), None);
        assert_eq!(crossing(&[[0., 0.], [2., 2.], [2., 0.], [0., 2.]]), Some([0, 2]));
        assert_eq!(crossing(&[[0., 0.], [2., 0.], [2., 2.], [2., 0.], [0., 2.]]).map(|[i, _]| i), Some(0));
        assert_eq!(crossing(&[[0., 0.], [2., 0.], [1., 0.], [1., 2.]]), Some([0, 1]));
        assert_eq!(crossing(&[[0., 0.], [0., 0.], [1., 0.], [1., 2.]]).map(|[i, _]| i), Some(0));
    }
}
