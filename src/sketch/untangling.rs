//! Closed lines that cross themselves by a little, as hands draw them.

use i_overlay::core::fill_rule::FillRule;
use i_overlay::float::simplify::SimplifyShape;

use super::arrangement::{Conflict, Contact};
use super::ring::{Ring, signed_area};

/// The share of what a line winds round that may be lost with its loops, and of holes between them that may be filled.
const SMALL: f64 = 0.03;

/// The rings without the loops of those that cross themselves, and which those are. None where rings cross others or
/// touch, where there are `limit` crossings or more, or where a loop is no small one: what then belongs together is for
/// the drawer to say.
pub(super) fn untangled(rings: &[Ring], conflict: &Conflict, limit: usize) -> Option<(Vec<Ring>, Vec<usize>)> {
    let Conflict::Contacts(contacts) = conflict else { return None };
    if contacts.len() >= limit {
        return None;
    }
    let own_crossing = |contact: &Contact| match contact {
        Contact::Edges(a, b) => (a.ring == b.ring).then_some(a.ring),
        Contact::Points(..) | Contact::EdgePoint(..) => None,
    };
    let mut crossed: Vec<usize> = contacts.iter().map(own_crossing).collect::<Option<_>>()?;
    crossed.sort_unstable();
    crossed.dedup();
    let mut untangled = rings.to_vec();
    for &ring in &crossed {
        untangled[ring] = without_loops(&rings[ring])?;
    }
    Some((untangled, crossed))
}

/// The outer bound of the largest piece of what the ring winds round, where that is nearly all.
fn without_loops(ring: &Ring) -> Option<Ring> {
    let area = |points: &Vec<[f64; 2]>| signed_area(points).abs();
    let pieces = vec![ring.points.clone()].simplify_shape_as::<i64>(FillRule::NonZero);
    let total: f64 = pieces.iter().flatten().map(area).sum();
    let outer = pieces.into_iter().filter_map(|piece| piece.into_iter().next());
    let largest =
        outer.max_by(|a, b| area(a).total_cmp(&area(b))).filter(|bound| area(bound) >= (1.0 - SMALL) * total)?;
    Some(Ring::mended(&largest).0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sketch::arrangement::Arrangement;

    fn ring(points: &[[f64; 2]]) -> Ring {
        Ring::mended(points).0
    }

    fn of(rings: &[Ring]) -> Option<(Vec<Ring>, Vec<usize>)> {
        let points: Vec<Vec<[f64; 2]>> = rings.iter().map(|ring| ring.points.clone()).collect();
        let conflict = Arrangement::new(&points, 8).err().expect("the rings cross");
        untangled(rings, &conflict, 8)
    }

    #[test]
    fn a_small_loop_is_cut_off() {
        // The last line comes in over the first one and leaves a loop at the corner.
        let crossed = ring(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.1, 0.1], [0.1, -0.1]]);
        let (rings, of_rings) = of(std::slice::from_ref(&crossed)).unwrap();
        assert_eq!(of_rings, [0]);
        let points = vec![rings[0].points.clone()];
        assert!(Arrangement::new(&points, 8).is_ok());
        assert!((rings[0].signed_area().abs() - 0.95).abs() < 0.01, "{}", rings[0].signed_area());
        let hole = ring(&[[0.4, 0.4], [0.4, 0.6], [0.6, 0.6]]);
        assert_eq!(of(&[crossed, hole.clone()]).unwrap().0[1], hole);
    }

    #[test]
    fn large_loops_and_rings_that_cross_others_stay() {
        assert!(of(&[ring(&[[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]])]).is_none());
        let square = ring(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
        assert!(of(&[square, ring(&[[0.5, 0.5], [1.5, 0.5], [1.0, 0.8]])]).is_none());
    }
}
