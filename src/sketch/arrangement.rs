//! The rings of a drawing as a constrained Delaunay triangulation, and where they meet.

use spade::handles::{FixedFaceHandle, FixedVertexHandle, InnerTag};
use spade::{ConstrainedDelaunayTriangulation, InsertionError, Point2, Triangulation};

pub(super) type Cdt = ConstrainedDelaunayTriangulation<Point2<f64>>;

/// The edge or point of a drawing: ring, and position in the ring. Edge i joins point i to the next.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Place {
    pub ring: usize,
    pub position: usize,
}

/// Two parts of a drawing that share a point and should not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Contact {
    /// Two points at one place.
    Points(Place, Place),
    /// An edge runs through a point.
    EdgePoint(Place, Place),
    /// Two edges cross.
    Edges(Place, Place),
}

/// Why rings could not be arranged.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Conflict {
    Contacts(Vec<Contact>),
    /// A coordinate that spade does not take; coordinates in the unit square snapped to zero are never refused.
    Coordinate(InsertionError),
}

/// Rings that meet nowhere, every edge a constraint.
pub(super) struct Arrangement<'a> {
    rings: &'a [Vec<[f64; 2]>],
    /// Handle of a ring's first point.
    starts: Vec<usize>,
    pub cdt: Cdt,
}

impl<'a> Arrangement<'a> {
    /// The arrangement of rings of at least three points each, inside the square from −1 to 1, in O(n log n) for
    /// drawings as they come.
    ///
    /// # Errors
    /// Where rings touch or cross themselves or each other: at most `limit` contacts, in the order of the edges.
    pub fn new(rings: &'a [Vec<[f64; 2]>], limit: usize) -> Result<Self, Conflict> {
        let contacts = coincident(rings, limit);
        if !contacts.is_empty() {
            return Err(Conflict::Contacts(contacts));
        }
        let starts = rings
            .iter()
            .scan(0, |next, ring| {
                let start = *next;
                *next += ring.len();
                Some(start)
            })
            .collect();
        // The frame keeps the figure's edges off the convex hull, where refinement would split them for nothing.
        let points = rings.iter().flatten().copied().chain(FRAME).map(|[x, y]| Point2::new(x, y)).collect();
        let cdt = Cdt::try_bulk_load_cdt(points, Vec::new(), |_| {}).map_err(Conflict::Coordinate)?;
        let mut arrangement = Self { rings, starts, cdt };
        let contacts = arrangement.constrain(limit);
        if contacts.is_empty() { Ok(arrangement) } else { Err(Conflict::Contacts(contacts)) }
    }

    /// For every ring how many rings contain it: 0 for an outline, 1 for its holes.
    pub fn depths(&self) -> Vec<usize> {
        let levels = self.levels();
        let level = |ring: usize| {
            let [from, to] = self.edge(Place { ring, position: 0 });
            let edge = self.cdt.get_edge_from_neighbors(from, to)?;
            let sides = [edge.face(), edge.rev().face()];
            sides.map(|face| face.as_inner().map_or(0, |inner| levels[inner.fix().index()])).into_iter().min()
        };
        // Every constraint is an edge of the triangulation, so that the default is never taken.
        (0..self.rings.len()).map(|ring| level(ring).unwrap_or(0)).collect()
    }

    /// For every face, by index, the number of rings around it.
    fn levels(&self) -> Vec<usize> {
        let mut levels = vec![usize::MAX; self.cdt.num_all_faces()];
        let mut front: Vec<FixedFaceHandle<InnerTag>> =
            self.cdt.convex_hull().filter_map(|edge| edge.rev().face().as_inner()).map(|face| face.fix()).collect();
        for level in 0.. {
            let mut next = Vec::new();
            while let Some(face) = front.pop() {
                if levels[face.index()] != usize::MAX {
                    continue;
                }
                levels[face.index()] = level;
                for edge in self.cdt.face(face).adjacent_edges() {
                    let Some(neighbour) = edge.rev().face().as_inner() else { continue };
                    let across = if edge.is_constraint_edge() { &mut next } else { &mut front };
                    across.push(neighbour.fix());
                }
            }
            if next.is_empty() {
                break;
            }
            front = next;
        }
        levels
    }

    /// Makes every edge of every ring a constraint and returns the contacts that forbid it.
    fn constrain(&mut self, limit: usize) -> Vec<Contact> {
        let mut contacts = Vec::new();
        for ring in 0..self.rings.len() {
            for position in 0..self.rings[ring].len() {
                let place = Place { ring, position };
                let [from, to] = self.edge(place);
                let made = self.cdt.try_add_constraint(from, to);
                match made[..] {
                    [_] => {}
                    [first, ..] => {
                        let through = self.cdt.directed_edge(first).to().fix();
                        contacts.push(Contact::EdgePoint(place, self.place(through)));
                    }
                    [] => contacts.extend(self.crossed(from, to).map(|other| Contact::Edges(other, place))),
                }
                if contacts.len() >= limit {
                    return contacts;
                }
            }
        }
        contacts
    }

    /// The first edge of a ring that the line between two points crosses.
    fn crossed(&self, from: FixedVertexHandle, to: FixedVertexHandle) -> Option<Place> {
        let edge = self.cdt.get_conflicting_edges_between_vertices(from, to).next()?;
        let [a, b] = [edge.from(), edge.to()].map(|vertex| self.place(vertex.fix()));
        // The earlier end names the edge, but for the one that closes a ring.
        let (first, last) = (a.min(b), a.max(b));
        Some(if last.position == first.position + 1 { first } else { last })
    }

    fn edge(&self, Place { ring, position }: Place) -> [FixedVertexHandle; 2] {
        let next = (position + 1) % self.rings[ring].len();
        [position, next].map(|i| FixedVertexHandle::from_index(self.starts[ring] + i))
    }

    fn place(&self, vertex: FixedVertexHandle) -> Place {
        let ring = self.starts.partition_point(|&start| start <= vertex.index()) - 1;
        Place { ring, position: vertex.index() - self.starts[ring] }
    }
}

/// Corners of a square well outside of every drawing.
const FRAME: [[f64; 2]; 4] = [[-4.0, -4.0], [4.0, -4.0], [4.0, 4.0], [-4.0, 4.0]];

/// Pairs of points at one place.
fn coincident(rings: &[Vec<[f64; 2]>], limit: usize) -> Vec<Contact> {
    let mut places: Vec<([f64; 2], Place)> = Vec::with_capacity(rings.iter().map(Vec::len).sum());
    for (ring, points) in rings.iter().enumerate() {
        places.extend(points.iter().enumerate().map(|(position, &point)| (point, Place { ring, position })));
    }
    places.sort_by(|(p, a), (q, b)| p[0].total_cmp(&q[0]).then(p[1].total_cmp(&q[1])).then(a.cmp(b)));
    let pairs = places.windows(2).filter(|pair| pair[0].0 == pair[1].0);
    pairs.map(|pair| Contact::Points(pair[0].1, pair[1].1)).take(limit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rectangle([x0, y0]: [f64; 2], [x1, y1]: [f64; 2]) -> Vec<[f64; 2]> {
        vec![[x0, y0], [x1, y0], [x1, y1], [x0, y1]]
    }

    fn contacts(rings: &[Vec<[f64; 2]>]) -> Vec<Contact> {
        match Arrangement::new(rings, 10) {
            Err(Conflict::Contacts(contacts)) => contacts,
            Err(Conflict::Coordinate(error)) => panic!("{error}"),
            Ok(_) => Vec::new(),
        }
    }

    #[test]
    fn points_keep_their_order_in_the_triangulation() {
        let n = 1000;
        let ring: Vec<[f64; 2]> = (0..n)
            .map(|i| (i as f64 / n as f64 * std::f64::consts::TAU).sin_cos())
            .map(|(sin, cos)| [0.5 * cos, 0.5 * sin])
            .collect();
        let rings = [ring];
        let arrangement = Arrangement::new(&rings, 1).ok().unwrap();
        for (vertex, &[x, y]) in arrangement.cdt.vertices().zip(&rings[0]) {
            assert_eq!(vertex.position(), Point2::new(x, y));
        }
        assert_eq!(arrangement.cdt.num_constraints(), n);
    }

    #[test]
    fn depths_count_the_rings_around() {
        let rings = [
            rectangle([-0.5, -0.5], [0.5, 0.5]),
            rectangle([-0.4, -0.4], [0.1, 0.1]),
            rectangle([-0.3, -0.3], [0.0, 0.0]),
            rectangle([0.6, 0.6], [0.7, 0.7]),
        ];
        assert_eq!(Arrangement::new(&rings, 1).ok().unwrap().depths(), [0, 1, 2, 0]);
    }

    #[test]
    fn crossing_edges_are_named() {
        let bow = vec![[0.0, 0.0], [0.5, 0.5], [0.5, 0.0], [0.0, 0.5]];
        let [a, b] = [0, 2].map(|position| Place { ring: 0, position });
        assert_eq!(contacts(&[bow]), [Contact::Edges(a, b)]);
    }

    #[test]
    fn the_closing_edge_is_named_by_its_first_point() {
        let bow = vec![[0.5, 0.5], [0.5, 0.0], [0.0, 0.5], [0.0, 0.0]];
        let [a, b] = [1, 3].map(|position| Place { ring: 0, position });
        assert_eq!(contacts(&[bow]), [Contact::Edges(a, b)]);
    }

    #[test]
    fn touching_points_and_edges_are_named() {
        let square = rectangle([0.0, 0.0], [0.5, 0.5]);
        let corner = vec![[0.0, 0.0], [0.2, 0.1], [0.1, 0.2]];
        let [a, b] = [0, 1].map(|ring| Place { ring, position: 0 });
        assert_eq!(contacts(&[square.clone(), corner]), [Contact::Points(a, b)]);
        let side = vec![[0.25, 0.0], [0.3, 0.1], [0.2, 0.1]];
        assert_eq!(contacts(&[square, side]), [Contact::EdgePoint(a, b)]);
    }
}
