//! A shape rebuilt from its first eigenfunctions.

use super::Spectrum;

/// Σ_i ⟨p, φ_i⟩ φ_i of the coordinates p of the vertices (n × 3), the inner product being that of the masses: the shape as far as the
/// eigenfunctions of the spectrum describe it.
pub fn rebuilt(spectrum: &Spectrum, positions: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let phi = spectrum.eigenfunctions.as_ref();
    let mut places = vec![[0.0; 3]; positions.len()];
    for i in 0..spectrum.len() {
        let column = phi.col(i);
        let mut coefficient = [0.0; 3];
        for ((p, mass), value) in positions.iter().zip(&spectrum.mass).zip(column.iter()) {
            (0..3).for_each(|axis| coefficient[axis] += mass * value * p[axis]);
        }
        for (place, value) in places.iter_mut().zip(column.iter()) {
            (0..3).for_each(|axis| place[axis] += coefficient[axis] * value);
        }
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::solids::sphere;
    use crate::numerics::Unwatched;
    use crate::spectral::{Boundary, spectrum};

    #[test]
    fn a_sphere_is_its_first_four_eigenfunctions_and_its_middle_the_first() {
        let mesh = sphere(14, 20);
        let of = |k: usize| spectrum(&mesh, 30, Boundary::Neumann, &Unwatched).unwrap().at_unit_area(k);
        let away = |k: usize| {
            let each = rebuilt(&of(k), mesh.positions()).into_iter().zip(mesh.positions());
            each.map(|(p, q)| (0..3).map(|i| (p[i] - q[i]).powi(2)).sum::<f64>().sqrt()).fold(0.0, f64::max)
        };
        let [one, four, all] = [away(1), away(4), away(30)];
        // A sphere of area 1.
        let radius = (0.25 / std::f64::consts::PI).sqrt();
        assert!(
            (one - radius).abs() < 0.01 * radius && four < 0.01 * radius && all <= four + 1e-9,
            "{one} {four} {all}"
        );
    }
}
