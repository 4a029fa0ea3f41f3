//! Eyes that are drawn, and where on the body eyes are: on the head, which is mostly the highest of it.

use super::Upright;
use crate::alignment::prepared::{FlatShape, PreparedMesh};
use crate::geometry::dot;

/// Less of the body's area than this within so far of a place is the end of a tail or of an arm, even of one held high.
const THIN: f64 = 0.035;
const AROUND: f64 = 0.2;

/// Drawn eyes and the top of the head.
#[derive(Clone, Copy)]
pub struct Eyes<'a> {
    /// Vertices of the sketch.
    pub drawn: &'a [u32],
    /// For every vertex of the mesh its distance from the highest place of the body that is not thin.
    pub from_top: &'a [f32],
}

impl<'a> Eyes<'a> {
    /// The eyes of the sketch, where it has any and it is known which way is up on the mesh.
    pub fn of(shape: &'a FlatShape, mesh: &'a PreparedMesh, upright: Option<Upright>) -> Option<Eyes<'a>> {
        let up = upright.filter(|_| !shape.eyes.is_empty())?.mesh;
        let is_thick = |field: &&Vec<f32>| {
            let near = field.iter().zip(&mesh.masses).filter(|&(&d, _)| f64::from(d) < AROUND);
            near.map(|(_, mass)| mass).sum::<f64>() >= THIN
        };
        let height = |sample: u32| dot(up, mesh.positions[sample as usize]);
        let fields = mesh.distances.samples.iter().zip(&mesh.distances.fields);
        let (_, top) =
            fields.filter(|(_, field)| is_thick(field)).max_by(|(a, _), (b, _)| height(**a).total_cmp(&height(**b)))?;
        Some(Eyes { drawn: &shape.eyes, from_top: top })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TriangleMesh;
    use crate::mesh::solids::{ball, sheet};
    use crate::numerics::Unwatched;

    /// A trunk along x, its head raised at the one end and a thin tail even higher at the other.
    fn animal() -> TriangleMesh {
        ball(24, 24, |[x, y, z]| {
            let (head, tail) = ((x - 0.7).max(0.0), (-0.7 - x).max(0.0));
            let thin = if x < -0.6 { 0.08 } else { 1.0 };
            [y * thin, z * thin + 4.0 * head + 8.0 * tail, 3.0 * x]
        })
    }

    #[test]
    fn the_head_is_high_and_thick() {
        let mesh = PreparedMesh::new(&animal(), &Unwatched).unwrap();
        let shape = || FlatShape::new(&sheet(6, 6), &Unwatched).unwrap();
        let upright = Some(Upright { sketch: [0.0, 1.0], mesh: mesh.axes.along([0.0, 1.0, 0.0]) });
        let seeing = shape().with_eyes(vec![3]);
        let eyes = Eyes::of(&seeing, &mesh, upright).unwrap();
        let along = |v: &usize| mesh.axes.back(mesh.positions[*v])[2];
        let vertices = 0..mesh.positions.len();
        let head = vertices.clone().max_by(|a, b| along(a).total_cmp(&along(b))).unwrap();
        let tail = vertices.min_by(|a, b| along(a).total_cmp(&along(b))).unwrap();
        assert!(
            eyes.from_top[head] < 0.2 && eyes.from_top[tail] > 1.0,
            "{} {}",
            eyes.from_top[head],
            eyes.from_top[tail]
        );
        assert_eq!(eyes.drawn, [3]);
        assert!(Eyes::of(&shape(), &mesh, upright).is_none());
        assert!(Eyes::of(&seeing, &mesh, None).is_none());
    }
}
