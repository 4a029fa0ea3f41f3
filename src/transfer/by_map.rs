//! Taken by the functional map.

use faer::Mat;

use super::request::{Moved, Shape, Values};
use crate::correspondence::inverse;
use crate::numerics::{Cancelled, Watch};
use crate::pipeline::Bases;
use crate::regions::Regions;

/// What is given at the vertices of one shape, at those of the other; of the sketch there are m.
pub fn taken(from: Shape, given: &Values<'_>, bases: &Bases, m: usize) -> Moved {
    let led = |values: &[f64], columns: usize| bases.led(from, values, columns, m);
    match given {
        Values::Function(values) => {
            Moved::Function { values: led(values, 1).into_iter().map(|row| Some(row?[0])).collect() }
        }
        Values::Labels(values) => {
            let mut labels = values.to_vec();
            labels.sort_unstable();
            labels.dedup();
            let indicators: Vec<f64> = values
                .iter()
                .flat_map(|value| labels.iter().map(move |label| if value == label { 1.0 } else { 0.0 }))
                .collect();
            let largest = |row: Vec<f64>| {
                let best = (0..row.len()).reduce(|best, i| if row[i] > row[best] { i } else { best });
                best.map_or(Regions::NONE, |i| labels[i])
            };
            let rows = led(&indicators, labels.len()).into_iter();
            Moved::Labels { values: rows.map(|row| row.map_or(Regions::NONE, largest)).collect() }
        }
        Values::Colours(values) => {
            let colour = |row: Vec<f64>| [0, 1, 2].map(|i| row[i].clamp(0.0, 1.0));
            Moved::Colours { values: led(values.as_flattened(), 3).into_iter().map(|row| row.map(colour)).collect() }
        }
    }
}

/// For every vertex of the file the vertex of the sketch with the nearest image.
pub fn inverse(bases: &Bases, watch: &dyn Watch) -> Result<Vec<Option<usize>>, Cancelled> {
    let Bases { phi, psi, figure, c } = bases;
    let found = inverse::of_map(c.as_ref(), phi.eigenfunctions.as_ref(), psi.eigenfunctions.as_ref(), watch)?;
    Ok(figure.of_file().map(|own| Some(found[own?] as usize)).collect())
}

impl Bases {
    /// Functions of one shape, a row of `columns` numbers for every vertex, led to the other: from the sketch Ψ C Φᵀ M f, from
    /// the mesh Φ Cᵀ Ψᵀ M f, M being the masses. None where a vertex of the file is not of the figure.
    fn led(&self, from: Shape, values: &[f64], columns: usize, m: usize) -> Vec<Option<Vec<f64>>> {
        let Bases { phi, psi, figure, c } = self;
        let row = |of: &Mat<f64>, i: usize| of.row(i).iter().copied().collect::<Vec<f64>>();
        match from {
            Shape::Sketch => {
                let weighed = Mat::from_fn(m, columns, |x, j| phi.mass[x] * values[x * columns + j]);
                let led = &psi.eigenfunctions * (c * (phi.eigenfunctions.transpose() * weighed));
                figure.of_file().map(|own| Some(row(&led, own?))).collect()
            }
            Shape::Mesh => {
                let n = figure.vertices.len();
                let at = |y: usize| figure.vertices[y] as usize * columns;
                let weighed = Mat::from_fn(n, columns, |y, j| psi.mass[y] * values[at(y) + j]);
                let led = &phi.eigenfunctions * (c.transpose() * (psi.eigenfunctions.transpose() * weighed));
                (0..m).map(|x| Some(row(&led, x))).collect()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::figure::Figure;
    use crate::mesh::file_mesh::FileMesh;
    use crate::mesh::solids::sheet;
    use crate::numerics::Unwatched;
    use crate::spectral::{Boundary, spectrum};

    /// A sheet matched to itself by the identity, with k eigenfunctions.
    fn identity(k: usize) -> (Bases, usize) {
        let flat = sheet(8, 6);
        let m = flat.positions().len();
        let of = |k: usize| spectrum(&flat, k, Boundary::Neumann, &Unwatched).unwrap().at_unit_area(k);
        let figure = Figure::largest(&FileMesh::from(flat.clone()));
        (Bases { phi: of(k), psi: of(k), figure, c: Mat::identity(k, k) }, m)
    }

    #[test]
    fn by_the_identity_a_function_of_the_basis_stays_what_it_is() {
        let (bases, m) = identity(12);
        let values: Vec<f64> = (0..m).map(|x| 3.0 * bases.phi.eigenfunctions[(x, 4)] - 1.0).collect();
        for from in [Shape::Sketch, Shape::Mesh] {
            let Moved::Function { values: moved } = taken(from, &Values::Function(&values), &bases, m) else {
                panic!("a function becomes a function");
            };
            assert!(moved.iter().zip(&values).all(|(moved, value)| (moved.unwrap() - value).abs() < 1e-9));
        }
    }

    #[test]
    fn labels_stay_where_they_are_but_for_their_borders() {
        let (bases, m) = identity(40);
        let values: Vec<i32> = (0..m).map(|x| if x % 9 < 4 { 2 } else { -1 }).collect();
        let Moved::Labels { values: moved } = taken(Shape::Mesh, &Values::Labels(&values), &bases, m) else {
            panic!("labels become labels");
        };
        assert!(moved.iter().zip(&values).filter(|(a, b)| a == b).count() * 10 >= m * 9);
        assert_eq!(inverse(&bases, &Unwatched).unwrap(), (0..m).map(Some).collect::<Vec<_>>());
    }

    #[test]
    fn colours_stay_within_their_range() {
        let (bases, m) = identity(10);
        let values: Vec<[f64; 3]> = (0..m).map(|x| if x == 5 { [1.0, 0.0, 1.0] } else { [0.0; 3] }).collect();
        let Moved::Colours { values } = taken(Shape::Sketch, &Values::Colours(values.into()), &bases, m) else {
            panic!("colours become colours");
        };
        assert!(values.iter().flatten().flatten().all(|x| (0.0..=1.0).contains(x)) && values[5].unwrap()[0] > 0.0);
    }
}
