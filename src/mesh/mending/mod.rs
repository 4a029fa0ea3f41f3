//! A sound surface made of whatever triangles a file has.
//!
//! A surface is told by which sides of its triangles are one edge; what its vertices are follows from that. So nothing is
//! moved and nothing invented: seams close because two sides become one edge, an edge of three triangles opens because
//! one of them finds no partner, and two fans that meet in a point are two vertices.

mod doubles;
mod fans;
pub(super) mod gluing;
mod places;

use super::edges::{self, Edges, HalfEdge, triangle_of};
use super::sound::Sound;
use super::soundness;
use super::winding::{Winding, wound};
use fans::{Fans, fans};
use gluing::{ALONE, Gluing, glued};

/// How often edges are looked at that several pairs of triangles still share.
const ROUNDS: usize = 16;

/// What had to be mended, in triangles and vertices of the file.
#[derive(Debug, Default)]
pub(super) struct Mends {
    /// Triangles left out: two of their corners are one, or they have no area and join nothing.
    pub degenerate: Vec<usize>,
    /// Triangles without area that are kept for what they join.
    pub flat: Vec<usize>,
    /// Triangles left out because another one is in their place.
    pub doubled: Vec<usize>,
    /// Edges where more than two triangles met, by the lowest vertices at their ends.
    pub crowded: Vec<[u32; 2]>,
    /// Vertices where fans of triangles met in a point only.
    pub pinched: Vec<u32>,
    /// Triangles turned over.
    pub flipped: Vec<usize>,
    /// Edges where a one-sided surface was cut.
    pub one_sided: Vec<[u32; 2]>,
}

/// The surface that triangles of sound, existing vertices make, and what was mended for it; nothing where no triangle has
/// an area. A surface that needs no mending keeps its vertices and triangles. O(n log n).
pub(super) fn mended(positions: &[[f64; 3]], triangles: &[[u32; 3]]) -> (Option<Sound>, Mends) {
    let mut mends = Mends::default();
    let mut rest = Rest { triangles: triangles.to_vec(), numbers: (0..triangles.len()).collect() };
    mends.degenerate = rest.without(|&[a, b, c], _| a == b || b == c || c == a);
    mends.doubled = rest.without_repeated(|v| v);
    let twins = doubles::twins(positions, &mut rest, &mut mends.doubled);

    let edges = Edges::of(&rest.triangles);
    let mut places = places::places(positions, &edges, &loose(positions.len(), &edges));
    let place = |v: u32| places[v as usize];
    mends.degenerate.extend(rest.without(|t, _| matches!(t.map(place), [a, b, c] if a == b || b == c || c == a)));
    mends.doubled.extend(rest.without_repeated(place));

    let mut gluing = glued(positions, &rest.triangles, &places);
    let hanging = flat(positions, &rest, &gluing, &mut mends);
    if hanging.contains(&true) {
        mends.degenerate.extend(rest.without(|_, t| hanging[t]));
        gluing = glued(positions, &rest.triangles, &places);
    }
    mends.crowded = gluing.crowded.clone();
    if rest.triangles.len() <= mends.flat.len() {
        return (None, mends);
    }
    for (twin, place) in twins {
        places[twin as usize] = places[place as usize];
    }
    let surface = surface(positions, rest, &places, gluing.partners, &mut mends);
    [&mut mends.degenerate, &mut mends.doubled].into_iter().for_each(|list| list.sort_unstable());
    (surface, mends)
}

/// The triangles that are left.
struct Rest {
    triangles: Vec<[u32; 3]>,
    /// Per triangle its number in the file, ascending.
    numbers: Vec<usize>,
}

impl Rest {
    /// Leaves out the triangles that `goes` of, by their vertices and their place in the rest; their numbers.
    fn without(&mut self, mut goes: impl FnMut(&[u32; 3], usize) -> bool) -> Vec<usize> {
        let going: Vec<bool> = self.triangles.iter().enumerate().map(|(t, triangle)| goes(triangle, t)).collect();
        let gone = self.numbers.iter().zip(&going).filter_map(|(&number, &goes)| goes.then_some(number)).collect();
        let mut stays = going.iter().map(|goes| !goes);
        self.triangles.retain(|_| stays.next().unwrap_or(true));
        let mut stays = going.iter().map(|goes| !goes);
        self.numbers.retain(|_| stays.next().unwrap_or(true));
        gone
    }

    /// Leaves out triangles whose corners are in the places of an earlier one's.
    fn without_repeated(&mut self, place: impl Fn(u32) -> u32) -> Vec<usize> {
        let placed: Vec<[u32; 3]> = self.triangles.iter().map(|t| t.map(&place)).collect();
        let firsts = soundness::firsts(&placed);
        self.without(|_, t| firsts[t] != t)
    }
}

/// The vertices of edges that are not those of exactly two triangles, ascending.
fn loose(vertices: usize, edges: &Edges) -> Vec<u32> {
    let mut is_loose = vec![false; vertices];
    for edge in edges.iter().filter(|edge| edge.half_edges().len() != 2) {
        edge.ends().into_iter().for_each(|v| is_loose[v as usize] = true);
    }
    (0..vertices as u32).filter(|&v| is_loose[v as usize]).collect()
}

/// Flags of the triangles that have no area and hang on others by one side or two, by themselves or with more of their
/// kind. Those that have no area and join others are told in `mends`.
fn flat(positions: &[[f64; 3]], rest: &Rest, gluing: &Gluing, mends: &mut Mends) -> Vec<bool> {
    let flat = soundness::flat(positions, &rest.triangles);
    let mut hanging = vec![false; rest.triangles.len()];
    let alone = |t: usize| gluing.partners[3 * t..3 * t + 3].contains(&ALONE);
    let mut found: Vec<usize> = (0..flat.len()).filter(|&t| flat[t] && alone(t)).collect();
    found.iter().for_each(|&t| hanging[t] = true);
    while let Some(t) = found.pop() {
        for &h in gluing.partners[3 * t..3 * t + 3].iter().filter(|&&h| h != ALONE) {
            let u = triangle_of(h);
            if flat[u] && !std::mem::replace(&mut hanging[u], true) {
                found.push(u);
            }
        }
    }
    mends.flat = (0..flat.len()).filter(|&t| flat[t] && !hanging[t]).map(|t| rest.numbers[t]).collect();
    hanging
}

/// The surface that is left, wound to one side, its vertices numbered; nothing where its edges cannot be told apart.
fn surface(
    positions: &[[f64; 3]],
    mut rest: Rest,
    places: &[u32],
    mut partners: Vec<HalfEdge>,
    mends: &mut Mends,
) -> Option<Sound> {
    for round in 0..ROUNDS {
        let Winding { flipped, parted } = wound(positions, &rest.triangles, places, &mut partners);
        mends.one_sided.extend(parted.into_iter().map(|h| edges::ends(&rest.triangles, h)));
        let Fans { mut triangles, origins } = fans(&rest.triangles, &partners, places);
        let ambiguous = ambiguous(&triangles, &flipped);
        if ambiguous.is_empty() {
            mends.pinched = origins.windows(2).filter(|pair| pair[0] == pair[1]).map(|pair| pair[0]).collect();
            mends.pinched.dedup();
            mends.flipped = (0..flipped.len()).filter(|&t| flipped[t]).map(|t| rest.numbers[t]).collect();
            let merged = merged(&rest.triangles, &triangles, &origins, places);
            triangles.iter_mut().zip(flipped).filter(|(_, flip)| *flip).for_each(|(t, _)| t.swap(1, 2));
            return Some(Sound { triangles, origins, merged, decimated: false });
        }
        let named = |h: &HalfEdge| edges::ends(&rest.triangles, *h);
        mends.crowded.extend(ambiguous.iter().map(|at_edge| named(&at_edge[0])));
        if round == 0 {
            // Cut open, such an edge is two in most cases.
            for h in ambiguous.into_iter().flatten() {
                let partner = std::mem::replace(&mut partners[h as usize], ALONE);
                if partner != ALONE {
                    partners[partner as usize] = ALONE;
                }
            }
        } else {
            let mut goes = vec![false; rest.triangles.len()];
            ambiguous.iter().flat_map(|at_edge| &at_edge[1..]).for_each(|&h| goes[triangle_of(h)] = true);
            mends.degenerate.extend(rest.without(|_, t| goes[t]));
            partners = glued(positions, &rest.triangles, places).partners;
        }
    }
    None
}

/// The half-edges at every edge that more than two triangles have, or two that run along it in one direction.
fn ambiguous(triangles: &[[u32; 3]], flipped: &[bool]) -> Vec<Vec<HalfEdge>> {
    let edges = Edges::of(triangles);
    let at_edges = edges.iter().map(|edge| edge.half_edges().collect::<Vec<_>>());
    let is_ambiguous = |at_edge: &Vec<HalfEdge>| match at_edge[..] {
        [_] => false,
        [g, h] => {
            let parallel = edges::ends(triangles, g) == edges::ends(triangles, h);
            parallel ^ flipped[triangle_of(g)] ^ flipped[triangle_of(h)]
        }
        _ => true,
    };
    at_edges.filter(is_ambiguous).collect()
}

/// Per vertex of the file the lowest vertex it is one with.
fn merged(named: &[[u32; 3]], triangles: &[[u32; 3]], origins: &[u32], places: &[u32]) -> Vec<u32> {
    let mut merged: Vec<u32> = (0..places.len() as u32).collect();
    let mut used = vec![false; places.len()];
    for (&v, &fan) in named.as_flattened().iter().zip(triangles.as_flattened()) {
        used[v as usize] = true;
        merged[v as usize] = merged[v as usize].min(origins[fan as usize]);
    }
    for v in (0..places.len()).filter(|&v| !used[v] && used[places[v] as usize]) {
        merged[v] = merged[places[v] as usize];
    }
    merged
}
