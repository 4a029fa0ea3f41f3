//! C and the part of the mesh that the sketch shows together [RCB+17].
//!
//! The functions of the mesh count where the indicator η does: B(η) = Ψᵀ M diag(η) G. As in the paper η(v) = ½ (1 + tanh(2 v − 1))
//! of a v without bounds; the length of the boundary is the total variation of η, which it is where η is 0 or 1.

use faer::{Mat, MatRef};

use super::MapError;
use super::problem::{Problem, least_squares};
use super::regulariser::{PartIndicator, Regulariser};
use super::solve::{Solution, solve};
use super::surface::Surface;
use crate::numerics::conjugate_gradient::{self, Smooth};
use crate::numerics::{Cancelled, Stopping, Watch, inner_product};

/// Iterations in η of one turn.
const ITERATIONS: usize = 30;
/// Vertices between two questions to the watcher.
const ROUND: usize = 1024;
/// v at first, as in the paper: nearly all of the mesh.
const FIRST: f64 = 1.0;

/// Functions that correspond where the mesh is shown.
pub struct Partial<'a> {
    /// What does not depend on the part: landmarks, points, terms.
    pub known: Problem,
    /// The functions of every pair of regions.
    pub groups: Vec<Group>,
    /// Ψ, n × l, and the masses, which sum to 1.
    pub basis: MatRef<'a, f64>,
    pub mass: &'a [f64],
    /// For every vertex of the mesh the group whose functions it has.
    pub group_of: Vec<Option<usize>>,
    pub surface: Surface,
}

/// Corresponding functions of a region of the sketch and one of the mesh.
pub struct Group {
    /// Coefficients of those of the sketch, k × p.
    pub sketch: Mat<f64>,
    /// What those of the mesh are made of, (l + 1) × p: at a vertex y of the region Σ_i f_i ψ_i(y)² + f_l.
    pub filters: Mat<f64>,
}

/// A functional map and the part that goes with it.
pub struct Shown {
    /// η, one of every vertex of the mesh, from 0 to 1.
    pub part: Vec<f64>,
    /// C⁰ of nearly the whole mesh, from which all begins and of which W is made.
    pub start: Mat<f64>,
    pub weights: Mat<f64>,
    /// Its report is that of C in all turns, by the energy of C and the part.
    pub solution: Solution,
}

impl Partial<'_> {
    /// The functions of every pair of regions, of sketch and mesh, for a part: k × p and l × p.
    ///
    /// # Errors
    /// [`Cancelled`] by the watcher.
    pub fn functions(&self, part: &[f64], watch: &dyn Watch) -> Result<Vec<[Mat<f64>; 2]>, Cancelled> {
        let of_group = |(group, gram): (&Group, Mat<f64>)| [group.sketch.clone(), gram * &group.filters];
        Ok(self.groups.iter().zip(self.grams(part, watch)?).map(of_group).collect())
    }

    /// The data term for a part.
    ///
    /// # Errors
    /// [`MapError`] if a shape does not fit, an entry is not finite, or the watcher cancels.
    pub fn problem(&self, part: &[f64], watch: &dyn Watch) -> Result<Problem, MapError> {
        let mut problem = self.known.clone();
        for [a, b] in self.functions(part, watch)? {
            problem.constrain(a.as_ref(), b.as_ref())?;
        }
        Ok(problem)
    }

    /// For every group G[a, i] = Σ_y m(y) η(y) ψ_a(y) s_i(y), l × (l + 1), s the squares of the row of Ψ and 1.
    fn grams(&self, part: &[f64], watch: &dyn Watch) -> Result<Vec<Mat<f64>>, Cancelled> {
        let l = self.basis.ncols();
        let mut grams = vec![Mat::<f64>::zeros(l, l + 1); self.groups.len()];
        for (y, (share, mass)) in part.iter().zip(self.mass).enumerate() {
            asked(y, watch)?;
            let Some(group) = self.group_of[y] else { continue };
            let (row, squares) = self.at(y);
            for (i, square) in squares.iter().enumerate() {
                let scaled = share * mass * square;
                let column = grams[group].col_as_slice_mut(i);
                column.iter_mut().zip(&row).for_each(|(entry, value)| *entry += scaled * value);
            }
        }
        Ok(grams)
    }

    /// By how much the area of the part is too large.
    fn over(&self, term: &PartIndicator, part: &[f64]) -> f64 {
        part.iter().zip(self.mass).map(|(share, mass)| share * mass).sum::<f64>() - term.area
    }

    /// What area and boundary of a part cost.
    fn of_shape(&self, term: &PartIndicator, part: &[f64]) -> f64 {
        let (length, _) = self.surface.variation(part);
        term.area_weight * self.over(term, part).powi(2) + term.boundary_weight * length
    }

    /// The row of Ψ at a vertex, and its squares and 1.
    fn at(&self, y: usize) -> (Vec<f64>, Vec<f64>) {
        let row: Vec<f64> = self.basis.row(y).iter().copied().collect();
        let squares = row.iter().map(|x| x * x).chain([1.0]).collect();
        (row, squares)
    }

    /// The largest Σ g(y)² over the functions of a vertex.
    fn largest(&self, watch: &dyn Watch) -> Result<f64, Cancelled> {
        let inner: Vec<Mat<f64>> = self.groups.iter().map(Group::inner).collect();
        let at = |y: usize| {
            asked(y, watch)?;
            let (_, squares) = self.at(y);
            Ok(self.group_of[y].map_or(0.0, |group| along(&inner[group], &squares, &squares)))
        };
        (0..self.mass.len()).map(at).try_fold(0.0, |largest: f64, found| Ok(largest.max(found?)))
    }
}

/// Asks the watcher before every so many vertices.
fn asked(vertex: usize, watch: &dyn Watch) -> Result<(), Cancelled> {
    if vertex.is_multiple_of(ROUND) { watch.proceed(0.0) } else { Ok(()) }
}

impl Group {
    /// F Fᵀ of the filters.
    fn inner(&self) -> Mat<f64> {
        &self.filters * self.filters.transpose()
    }
}

/// xᵀ M y.
fn along(matrix: &Mat<f64>, x: &[f64], y: &[f64]) -> f64 {
    let column = |i: usize| matrix.col_as_slice(i).iter().zip(x).map(|(entry, x)| entry * x).sum::<f64>();
    y.iter().enumerate().map(|(i, y)| y * column(i)).sum()
}

/// What is minimised in v for a given C: data, area and boundary, by √m v, so that lengths are those of functions on the surface.
struct OfPart<'a> {
    partial: &'a Partial<'a>,
    term: &'a PartIndicator,
    images: Vec<Image>,
    roots: &'a [f64],
    watch: &'a dyn Watch,
}

/// What of the functions of a group counts for a given C: ‖C A − G F‖²_F = ‖C A‖²_F − 2 ⟨C A Fᵀ, G⟩ + ⟨G F Fᵀ, G⟩.
struct Image {
    constant: f64,
    /// C A Fᵀ, l × (l + 1).
    cross: Mat<f64>,
    /// F Fᵀ.
    inner: Mat<f64>,
}

impl Image {
    fn of(c: &Mat<f64>, group: &Group) -> Image {
        let image = c * &group.sketch;
        Image { constant: image.squared_norm_l2(), cross: image * group.filters.transpose(), inner: group.inner() }
    }

    fn value(&self, gram: &Mat<f64>) -> f64 {
        let quadratic = inner_product((gram * &self.inner).as_ref(), gram.as_ref());
        self.constant - 2.0 * inner_product(self.cross.as_ref(), gram.as_ref()) + quadratic
    }
}

impl OfPart<'_> {
    fn part(&self, x: MatRef<'_, f64>) -> Vec<f64> {
        x.col(0).iter().zip(self.roots).map(|(x, root)| indicator(x / root)).collect()
    }

    fn value(&self, x: MatRef<'_, f64>) -> Result<f64, Cancelled> {
        let part = self.part(x);
        let grams = self.partial.grams(&part, self.watch)?;
        let data = self.images.iter().zip(&grams).map(|(image, gram)| image.value(gram));
        Ok(data.sum::<f64>() + self.partial.of_shape(self.term, &part))
    }

    fn gradient(&self, x: MatRef<'_, f64>) -> Result<Mat<f64>, Cancelled> {
        let Partial { mass, group_of, surface, .. } = self.partial;
        let part = self.part(x);
        let difference = |(image, gram): (&Image, Mat<f64>)| gram * &image.inner - &image.cross;
        let grams = self.partial.grams(&part, self.watch)?;
        let differences: Vec<Mat<f64>> = self.images.iter().zip(grams).map(difference).collect();
        let (_, by_length) = surface.variation(&part);
        let by_area = self.term.area_weight * self.partial.over(self.term, &part);
        let mut gradient = Mat::zeros(part.len(), 1);
        for y in 0..part.len() {
            asked(y, self.watch)?;
            let by_data = group_of[y].map_or(0.0, |group| {
                let (row, squares) = self.partial.at(y);
                along(&differences[group], &row, &squares)
            });
            // η′ = 1 − tanh² = 4 η (1 − η).
            let steepness = 4.0 * part[y] * (1.0 - part[y]);
            let slope = 2.0 * mass[y] * (by_data + by_area) + self.term.boundary_weight * by_length[y];
            gradient[(y, 0)] = slope * steepness / self.roots[y];
        }
        Ok(gradient)
    }
}

/// η(v).
fn indicator(v: f64) -> f64 {
    0.5 * (1.0 + (2.0 * v - 1.0).tanh())
}

/// C and the part in turns, from nearly the whole mesh. `weights` makes W of C⁰. Each turn minimises in one of both and lowers the
/// energy; that the least of all is reached is not known. The objective told is that of C and the part.
///
/// # Errors
/// As [`solve`].
pub fn shown(
    partial: &Partial<'_>,
    term: &PartIndicator,
    weights: &dyn Fn(&Mat<f64>) -> Mat<f64>,
    watch: &dyn Watch,
) -> Result<Shown, MapError> {
    let regulariser = Regulariser::PartIndicator(*term);
    let roots: Vec<f64> = partial.mass.iter().map(|mass| mass.sqrt()).collect();
    let mut x = Mat::from_fn(roots.len(), 1, |y, _| FIRST * roots[y]);
    let mut part = vec![indicator(FIRST); roots.len()];
    let problem = partial.problem(&part, watch)?;
    let start = least_squares(&problem)?;
    let w = weights(&start);
    let solved = |problem: &Problem, part: &[f64], from: Mat<f64>| {
        let mut solution = solve(problem, &regulariser, &w, from, watch)?;
        let of_shape = partial.of_shape(term, part);
        solution.report.history.iter_mut().for_each(|value| *value += of_shape);
        Ok::<_, MapError>(solution)
    };
    let mut solution = solved(&problem, &part, start.clone())?;
    // A unit of length for v: that by which the gradient of data and area at most grows.
    let step = 0.5 / (partial.largest(watch)? + term.area_weight).max(f64::MIN_POSITIVE);
    for _ in 0..term.rounds {
        let images = partial.groups.iter().map(|group| Image::of(&solution.c, group)).collect();
        let of_part = OfPart { partial, term, images, roots: &roots, watch };
        let h = Smooth {
            objective: |x: MatRef<'_, f64>| of_part.value(x),
            gradient: |x: MatRef<'_, f64>| of_part.gradient(x),
            step,
        };
        (x, _) = conjugate_gradient::minimise(&h, x, Stopping { max_iterations: ITERATIONS, tolerance: 0.0 }, watch)?;
        part = of_part.part(x.as_ref());
        let next = solved(&partial.problem(&part, watch)?, &part, solution.c)?;
        solution = Solution { c: next.c, report: solution.report.followed_by(next.report) };
    }
    Ok(Shown { part, start, weights: w, solution })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::TriangleMesh;
    use crate::mesh::solids::sheet;
    use crate::numerics::{Report, Unwatched, random};
    use crate::spectral::{Boundary, Spectrum, spectrum};

    const K: usize = 12;

    /// A sheet that grows wider, so that no part of it is like another, of which a drawing shows what is left of a line.
    fn seen_to(line: f64) -> (TriangleMesh, Spectrum, Vec<bool>) {
        let mesh = sheet(20, 10);
        let wider = |&[x, y, z]: &[f64; 3]| [x, y * (1.0 + x), z];
        let mesh = TriangleMesh::new(mesh.positions().iter().map(wider).collect(), mesh.triangles().to_vec()).unwrap();
        let spectrum = spectrum(&mesh, K, Boundary::Neumann, &Unwatched).unwrap().at_unit_area(K);
        let right = mesh.positions().iter().map(|p| p[0]).fold(0.0, f64::max);
        let inside = mesh.positions().iter().map(|p| p[0] <= line * right).collect();
        (mesh, spectrum, inside)
    }

    /// The functions of the whole sheet, and on the "sketch" what of them is inside, in the same basis: C is the identity.
    fn partial<'a>(mesh: &TriangleMesh, spectrum: &'a Spectrum, inside: &[bool]) -> Partial<'a> {
        let filters = random::normal(K + 1, 30, 1);
        let mut partial = Partial {
            known: Problem::unconstrained(K, K),
            groups: vec![Group { sketch: Mat::zeros(K, 30), filters }],
            basis: spectrum.eigenfunctions.as_ref(),
            mass: &spectrum.mass,
            group_of: vec![Some(0); spectrum.vertices()],
            surface: Surface::of(mesh),
        };
        let exact: Vec<f64> = inside.iter().map(|&inside| f64::from(u8::from(inside))).collect();
        let gram = partial.grams(&exact, &Unwatched).unwrap().swap_remove(0);
        partial.groups[0].sketch = gram * &partial.groups[0].filters;
        partial
    }

    fn slanted(c: &Mat<f64>) -> Mat<f64> {
        Mat::from_fn(c.nrows(), c.ncols(), |i, j| (i as f64 - j as f64).abs())
    }

    #[test]
    fn a_known_part_is_found() {
        for line in [0.4, 0.7] {
            let (mesh, spectrum, inside) = seen_to(line);
            let partial = partial(&mesh, &spectrum, &inside);
            let area: f64 = spectrum.mass.iter().zip(&inside).filter(|(_, inside)| **inside).map(|(m, _)| m).sum();
            let term =
                PartIndicator { gamma: 10.0, area, boundary_weight: 1.0, rounds: 10, ..PartIndicator::default() };
            let found = shown(&partial, &term, &slanted, &Unwatched).unwrap();
            let right: f64 = (found.part.iter().zip(&inside).zip(&spectrum.mass))
                .filter(|((share, inside), _)| (**share >= 0.5) == **inside)
                .map(|(_, mass)| mass)
                .sum();
            assert!(right > 0.9, "{line}: {right}");
        }
    }

    #[test]
    fn all_turns_are_told_from_the_first_start_on_by_one_energy() {
        let (mesh, spectrum, inside) = seen_to(0.4);
        let partial = partial(&mesh, &spectrum, &inside);
        for orthogonality in [0.0, 0.1] {
            let term = PartIndicator { rounds: 3, max_iterations: 20, orthogonality, ..PartIndicator::default() };
            let found = shown(&partial, &term, &slanted, &Unwatched).unwrap();
            let whole = partial.problem(&[indicator(FIRST)].repeat(spectrum.vertices()), &Unwatched).unwrap();
            assert_eq!(found.start, least_squares(&whole).unwrap());
            let Report { iterations, history, .. } = found.solution.report;
            // Each of four turns in C is of 20 iterations or, found directly, told at its end.
            assert_eq!((iterations, history.len()), if orthogonality > 0.0 { (80, 81) } else { (0, 5) });
            assert!(history.is_sorted_by(|before, after| after <= before), "{history:?}");
            let c = &found.solution.c;
            let weighted: f64 = (0..K * K).map(|i| (i / K, i % K)).map(|at| (slanted(c)[at] * c[at]).powi(2)).sum();
            let unlike = (c.transpose() * c - Mat::<f64>::identity(K, K)).squared_norm_l2();
            let data = partial.problem(&found.part, &Unwatched).unwrap().value(c.as_ref());
            let of_shape = partial.of_shape(&term, &found.part);
            let energy = data + term.gamma * weighted + orthogonality * unlike + of_shape;
            assert!((history.last().unwrap() - energy).abs() < 1e-9 * history[0]);
        }
    }

    #[test]
    fn the_gradient_is_the_slope_of_the_value() {
        let (mesh, spectrum, inside) = seen_to(0.5);
        let partial = partial(&mesh, &spectrum, &inside);
        let term = PartIndicator { area_weight: 3.0, boundary_weight: 2.0, ..PartIndicator::default() };
        let c = random::normal(K, K, 3);
        let images = partial.groups.iter().map(|group| Image::of(&c, group)).collect();
        let roots: Vec<f64> = spectrum.mass.iter().map(|mass| mass.sqrt()).collect();
        let n = roots.len();
        let of_part = OfPart { partial: &partial, term: &term, images, roots: &roots, watch: &Unwatched };
        let (x, direction, step) = (0.05 * random::normal(n, 1, 4), random::normal(n, 1, 5), 1e-6);
        let value = |x: Mat<f64>| of_part.value(x.as_ref()).unwrap();
        let difference = value(&x + step * &direction) - value(&x - step * &direction);
        let slope = inner_product(of_part.gradient(x.as_ref()).unwrap().as_ref(), direction.as_ref());
        assert!((difference / (2.0 * step) - slope).abs() < 1e-5 * slope.abs(), "{difference} {slope}");
    }

    #[test]
    fn within_every_evaluation_it_is_asked_whether_to_go_on() {
        struct Never;
        impl Watch for Never {
            fn proceed(&self, _fraction: f64) -> Result<(), Cancelled> {
                Err(Cancelled)
            }
        }
        let (mesh, spectrum, inside) = seen_to(0.5);
        let partial = partial(&mesh, &spectrum, &inside);
        let roots: Vec<f64> = spectrum.mass.iter().map(|mass| mass.sqrt()).collect();
        let term = PartIndicator::default();
        let of_part = OfPart { partial: &partial, term: &term, images: Vec::new(), roots: &roots, watch: &Never };
        let x = Mat::zeros(roots.len(), 1);
        assert_eq!(of_part.value(x.as_ref()), Err(Cancelled));
        assert_eq!(of_part.gradient(x.as_ref()).err(), Some(Cancelled));
        assert_eq!(partial.largest(&Never), Err(Cancelled));
    }

    #[test]
    fn the_data_term_is_that_of_functions_formed_at_the_vertices() {
        let (mesh, spectrum, inside) = seen_to(0.5);
        let partial = partial(&mesh, &spectrum, &inside);
        let part: Vec<f64> = (0..spectrum.vertices()).map(|y| 0.5 + 0.5 * (y as f64).sin()).collect();
        let Group { sketch, filters } = &partial.groups[0];
        let at = |y: usize, f: usize| {
            let (_, squares) = partial.at(y);
            (0..=K).map(|i| filters[(i, f)] * squares[i]).sum::<f64>()
        };
        let b = Mat::from_fn(K, filters.ncols(), |a, f| {
            (0..part.len())
                .map(|y| spectrum.mass[y] * part[y] * spectrum.eigenfunctions[(y, a)] * at(y, f))
                .sum::<f64>()
        });
        let c = random::normal(K, K, 6);
        let wanted = (&c * sketch - b).squared_norm_l2();
        assert!((partial.problem(&part, &Unwatched).unwrap().value(c.as_ref()) - wanted).abs() < 1e-9 * wanted);
        let image = Image::of(&c, &partial.groups[0]);
        assert!((image.value(&partial.grams(&part, &Unwatched).unwrap()[0]) - wanted).abs() < 1e-9 * wanted);
    }
}
