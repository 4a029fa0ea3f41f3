//! The colours of a sketch, carried over to a surface.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

use super::colour::Colour;
use crate::correspondence::REACH;
use crate::geometry::{length, subtract};
use crate::mesh::TriangleMesh;

/// The share of the reach from which colours fade.
const FADING: f64 = 0.6;
/// Rounds in which the seams between the colours of two answers are softened.
const SOFTENING: usize = 6;

/// The grey of a surface nobody's answer is near.
const PLAIN: f64 = 0.9;

/// The colour of what nobody's answer is near.
pub fn plain() -> Colour {
    Colour::grey(PLAIN)
}

/// A colour for every vertex of the mesh: of one that is answered the mean of the colours of those that answer it, of
/// others that of the nearest such vertex along the edges, softened, and farther off than [`REACH`] light grey.
///
/// `answers` are vertices of the mesh and the colours they get.
///
/// # Panics
/// Where an answer is no vertex of the mesh.
pub fn colours(mesh: &TriangleMesh, answers: impl IntoIterator<Item = (u32, Colour)>) -> Vec<Colour> {
    let n = mesh.positions().len();
    let mut sums = vec![([0.0; 3], 0.0); n];
    for (vertex, colour) in answers {
        let (sum, count) = &mut sums[vertex as usize];
        sum.iter_mut().zip(colour.oklab()).for_each(|(sum, x)| *sum += x);
        *count += 1.0;
    }
    let mut colours: Vec<[f64; 3]> = sums.iter().map(|&(sum, count)| sum.map(|x| x / f64::max(count, 1.0))).collect();
    let sources: Vec<u32> = (0..n as u32).filter(|&v| sums[v as usize].1 > 0.0).collect();
    let neighbours = Neighbours::of(mesh);
    let reach = REACH * mesh.area().sqrt();
    let Spread { distances, nearest } = spread(mesh, &neighbours, &sources, reach);
    for v in 0..n {
        if distances[v].is_finite() {
            colours[v] = colours[nearest[v] as usize];
        }
    }
    soften(&mut colours, &neighbours, &distances);
    let plain = plain();
    let faded = |(lab, distance): ([f64; 3], f64)| {
        let fade = ((distance / reach - FADING) / (1.0 - FADING)).clamp(0.0, 1.0);
        if fade < 1.0 { Colour::of_oklab(lab).mixed(plain, fade) } else { plain }
    };
    colours.into_iter().zip(distances).map(faded).collect()
}

/// The vertices that share an edge with a vertex, in one list: those of vertex v at `starts[v]..starts[v + 1]`.
struct Neighbours {
    starts: Vec<usize>,
    list: Vec<u32>,
}

impl Neighbours {
    fn of(mesh: &TriangleMesh) -> Neighbours {
        let sides = || mesh.triangles().iter().flat_map(|&[a, b, c]| [(a, b), (a, c), (b, a), (b, c), (c, a), (c, b)]);
        let mut starts = vec![0; mesh.positions().len() + 1];
        sides().for_each(|(v, _)| starts[v as usize + 1] += 1);
        (1..starts.len()).for_each(|v| starts[v] += starts[v - 1]);
        let (mut list, mut next) = (vec![0; starts[starts.len() - 1]], starts.clone());
        for (v, neighbour) in sides() {
            list[next[v as usize]] = neighbour;
            next[v as usize] += 1;
        }
        Neighbours { starts, list }
    }

    /// Those of a vertex, one on two triangles twice.
    fn around(&self, vertex: usize) -> &[u32] {
        &self.list[self.starts[vertex]..self.starts[vertex + 1]]
    }
}

/// For every vertex the length of the shortest path along edges from a source, infinite beyond the reach, and the
/// source.
struct Spread {
    distances: Vec<f64>,
    nearest: Vec<u32>,
}

fn spread(mesh: &TriangleMesh, neighbours: &Neighbours, sources: &[u32], reach: f64) -> Spread {
    let mut distances = vec![f64::INFINITY; mesh.positions().len()];
    let mut nearest: Vec<u32> = (0..distances.len() as u32).collect();
    let mut front = BinaryHeap::new();
    for &v in sources {
        distances[v as usize] = 0.0;
        front.push(Reverse((Length(0.0), v)));
    }
    while let Some(Reverse((Length(distance), vertex))) = front.pop() {
        let v = vertex as usize;
        if distance > distances[v] {
            continue;
        }
        for &w in neighbours.around(v) {
            let edge = length(subtract(mesh.positions()[v], mesh.positions()[w as usize]));
            let farther = distance + edge;
            if farther <= reach && farther < distances[w as usize] {
                distances[w as usize] = farther;
                nearest[w as usize] = nearest[v];
                front.push(Reverse((Length(farther), w)));
            }
        }
    }
    Spread { distances, nearest }
}

/// A finite length, in order of size.
#[derive(Clone, Copy, PartialEq)]
struct Length(f64);

impl Eq for Length {}

impl Ord for Length {
    fn cmp(&self, other: &Length) -> std::cmp::Ordering {
        self.0.total_cmp(&other.0)
    }
}

impl PartialOrd for Length {
    fn partial_cmp(&self, other: &Length) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

/// Takes the vertices between answers to the mean of themselves and their neighbours; answers stay.
fn soften(colours: &mut Vec<[f64; 3]>, neighbours: &Neighbours, distances: &[f64]) {
    for _ in 0..SOFTENING {
        let softened = |v: usize| {
            if distances[v] == 0.0 || distances[v].is_infinite() {
                return colours[v];
            }
            let (mut sum, mut count) = (colours[v], 1.0);
            for &w in neighbours.around(v).iter().filter(|&&w| distances[w as usize].is_finite()) {
                (0..3).for_each(|i| sum[i] += colours[w as usize][i]);
                count += 1.0;
            }
            sum.map(|x| x / count)
        };
        *colours = (0..colours.len()).map(softened).collect();
    }
}

#[cfg(test)]
mod tests {
    use super::super::colour::difference;
    use super::*;
    use crate::mesh::solids::{sheet, sphere};

    const RED: Colour = Colour([0.8, 0.1, 0.1]);
    const BLUE: Colour = Colour([0.1, 0.1, 0.8]);

    #[test]
    fn an_answer_keeps_the_mean_of_its_colours() {
        let mesh = sphere(20, 40);
        let colours = colours(&mesh, [(5, RED), (70, RED), (70, BLUE)]);
        assert!(difference(colours[5], RED) < 1e-6);
        assert!(difference(colours[70], RED.mixed(BLUE, 0.5)) < 1e-6);
    }

    #[test]
    fn colours_spread_along_the_surface_and_not_through_it() {
        // Two parallel sheets, a hundredth apart.
        let flat = sheet(10, 10);
        let n = flat.positions().len() as u32;
        let above = flat.positions().iter().map(|&[x, y, _]| [x, y, 0.01]);
        let positions = flat.positions().iter().copied().chain(above).collect();
        let triangles = flat.triangles().iter().copied().chain(flat.triangles().iter().map(|t| t.map(|v| v + n)));
        let mesh = TriangleMesh::new(positions, triangles.collect()).unwrap();
        let colours = colours(&mesh, [(60, RED)]);
        let plain = plain();
        assert!(difference(colours[61], RED) < 0.02, "a tenth of the side beside it");
        assert!(difference(colours[62], plain) < 1e-9);
        assert!(colours[n as usize..].iter().all(|&colour| difference(colour, plain) < 1e-9));
    }

    #[test]
    fn between_two_answers_colours_meet_without_a_seam() {
        let mesh = sheet(40, 40);
        let colours = colours(&mesh, [(20 * 41 + 18, RED), (20 * 41 + 22, BLUE)]);
        let middle = 20 * 41 + 20;
        assert!(difference(colours[middle - 1], colours[middle + 1]) < 0.7 * difference(RED, BLUE));
    }

    #[test]
    fn a_surface_without_answers_is_plain() {
        assert!(colours(&sphere(10, 10), []).iter().all(|&colour| colour == Colour::grey(PLAIN)));
    }
}
