//! How morph targets move the vertices of a mesh.

use gltf::{Accessor, Primitive};

use super::container::Container;

/// Offsets that are added at most, for each vertex that a file may hold: of the many targets that a face has few weigh anything.
const MOST_OFFSETS: usize = 16;

/// The most offsets that are added in a file that may hold so many triangles, and three vertices for each.
pub(super) fn most_offsets(triangles: usize) -> usize {
    triangles.saturating_mul(3 * MOST_OFFSETS)
}

/// The offsets of a primitive's targets that weigh anything, and what they weigh.
pub(super) fn targets<'a>(primitive: &Primitive<'a>, weights: &[f32]) -> impl Iterator<Item = (f64, Accessor<'a>)> {
    let weighed = primitive.morph_targets().zip(weights).filter(|(_, weight)| **weight != 0.0);
    weighed.filter_map(|(target, &weight)| Some((f64::from(weight), target.positions()?)))
}

/// Moves vertices by the offsets of a target.
pub(super) fn moved(
    positions: &mut [[f64; 3]],
    weight: f64,
    offsets: &Accessor,
    container: &Container,
) -> Result<(), String> {
    if offsets.count() != positions.len() {
        return Err("a morph target does not have an offset for every vertex".into());
    }
    for (position, offset) in positions.iter_mut().zip(container.numbers::<3>(offsets)?) {
        *position = [0, 1, 2].map(|i: usize| position[i] + weight * offset[i]);
    }
    Ok(())
}
