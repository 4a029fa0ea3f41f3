//! The total variation of functions on a surface.

use crate::geometry::{dot, subtract};
use crate::mesh::TriangleMesh;

/// Below this slope, in 1/√area, the total variation is rounded off, so that it has a gradient. A step from 0 to 1 over an edge of
/// a mesh of 5,000 vertices has one of about 50.
const ROUNDED: f64 = 1.0;

/// The triangles of a surface of area 1.
pub struct Surface(Vec<Triangle>);

struct Triangle {
    corners: [usize; 3],
    area: f64,
    /// |∇f|² = a d₁² + 2 b d₁ d₂ + c d₂² of the differences d of f from the first corner.
    metric: [f64; 3],
}

impl Surface {
    /// That of a mesh, scaled to area 1; triangles without area are left out.
    pub fn of(mesh: &TriangleMesh) -> Surface {
        let total = mesh.area().max(f64::MIN_POSITIVE);
        let triangle = |t: &[u32; 3]| {
            let [p, q, r] = t.map(|v| mesh.positions()[v as usize]);
            let (u, v) = (subtract(q, p), subtract(r, p));
            let [uu, uv, vv] = [dot(u, u), dot(u, v), dot(v, v)].map(|x| x / total);
            let determinant = uu * vv - uv * uv;
            let of_area = || Triangle {
                corners: t.map(|v| v as usize),
                area: 0.5 * determinant.sqrt(),
                metric: [vv, -uv, uu].map(|x| x / determinant),
            };
            (determinant > f64::EPSILON * uu * vv).then(of_area)
        };
        Surface(mesh.triangles().iter().filter_map(triangle).collect())
    }

    /// ∫ ‖∇f‖, rounded off, and its gradient by the values of f at the vertices.
    pub(super) fn variation(&self, f: &[f64]) -> (f64, Vec<f64>) {
        let (mut value, mut gradient) = (0.0, vec![0.0; f.len()]);
        for Triangle { corners: [i, j, k], area, metric: [a, b, c] } in &self.0 {
            let (d, e) = (f[*j] - f[*i], f[*k] - f[*i]);
            let slope = (a * d * d + 2.0 * b * d * e + c * e * e).max(0.0);
            let rounded = (slope + ROUNDED * ROUNDED).sqrt();
            value += area * (rounded - ROUNDED);
            let (by_d, by_e) = (area * (a * d + b * e) / rounded, area * (b * d + c * e) / rounded);
            gradient[*j] += by_d;
            gradient[*k] += by_e;
            gradient[*i] -= by_d + by_e;
        }
        (value, gradient)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::solids::sheet;

    #[test]
    fn the_variation_of_an_indicator_is_the_length_of_its_boundary() {
        // Over the middle of a sheet of 2 : 1 the boundary is half as long as the sheet: at area 1, 1/√2.
        let mesh = sheet(200, 100);
        let right = mesh.positions().iter().map(|p| p[0]).fold(0.0, f64::max);
        let f: Vec<f64> = mesh.positions().iter().map(|p| if p[0] < 0.5 * right { 1.0 } else { 0.0 }).collect();
        let (length, _) = Surface::of(&mesh).variation(&f);
        assert!((length - 0.5f64.sqrt()).abs() < 0.03, "{length}");
    }
}
