//! The weights W (l × k), small where C is expected to be large.

use faer::{Mat, MatRef};
use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

use super::diagonal::Diagonal;
use super::parameter::{Declared, number, number_above};
use crate::numerics::cosamp::{Sampling, sparse_approximation};

/// How W is made.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(tag = "method", rename_all = "snake_case", deny_unknown_fields)]
pub enum Weights {
    /// Distance from the line through the `sparsity` · k largest entries of C⁰, to a `power` (§3.2.5).
    Cosamp {
        #[serde(default = "sparsity")]
        #[schema(exclusive_minimum = 0, maximum = 10)]
        sparsity: f64,
        #[serde(default = "power")]
        #[schema(minimum = 0, maximum = 10)]
        power: f64,
    },
    /// Distance from the diagonal whose slope the two spectra tell (Rodolà et al. 2017).
    Slant {},
    /// The resolvent mask (Ren et al. 2019).
    Resolvent {},
    /// All ones.
    None {},
}

/// `Weights::Cosamp::sparsity`, in shares of k.
const SPARSITY: Declared<f64> =
    number_above("entries of C⁰ the line is fitted through, as a share of k", 0.8, 0.0, 10.0);

/// `Weights::Cosamp::power`.
const POWER: Declared<f64> = number("exponent of the distance from the line; 0 makes all weights 1", 1.2, 0.0, 10.0);

/// How fast the slant's weights fade with the index of the eigenfunctions: σ of \[RCB+17, §4.1\].
const FADING: f64 = 0.03;

/// W (l × k), none negative.
///
/// `c0` = C⁰ is l × k; `sketch_eigenvalues` (k) and `mesh_eigenvalues` (l) are ascending and in one unit, that is after
/// the spectral scale. C⁰ alone decides `cosamp`, the spectra alone `slant` and `resolvent`.
pub fn weights(kind: &Weights, c0: MatRef<'_, f64>, sketch_eigenvalues: &[f64], mesh_eigenvalues: &[f64]) -> Mat<f64> {
    match *kind {
        Weights::Cosamp { sparsity, power } => from_largest_entries(c0, sparsity, power),
        Weights::Slant {} => slant(sketch_eigenvalues, mesh_eigenvalues),
        Weights::Resolvent {} => resolvent(sketch_eigenvalues, mesh_eigenvalues),
        Weights::None {} => Mat::ones(c0.nrows(), c0.ncols()),
    }
}

/// What is wrong with the parameters of the weights: the name of each field at fault, and why.
pub fn faults(weights: &Weights) -> Vec<(&'static str, String)> {
    match *weights {
        Weights::Cosamp { sparsity, power } => [(SPARSITY.named("sparsity"), sparsity), (POWER.named("power"), power)]
            .into_iter()
            .filter_map(|(parameter, value)| Some((parameter.name, parameter.fault(value)?)))
            .collect(),
        Weights::Slant {} | Weights::Resolvent {} | Weights::None {} => vec![],
    }
}

/// wᵢⱼ = (distance from the line through the s = round(`sparsity` · k) largest entries of C⁰)^`power`, §3.2.5.
///
/// CoSaMP finds them with all entries of C⁰ as the measurements, Φ = I.
fn from_largest_entries(c0: MatRef<'_, f64>, sparsity: f64, power: f64) -> Mat<f64> {
    let (rows, columns) = c0.shape();
    let count = (sparsity * columns as f64).round().max(1.0) as usize;
    let entries: Vec<f64> = c0.col_iter().flat_map(|column| column.iter().copied()).collect();
    let identity = Sampling { signal: entries.len(), forward: <[f64]>::to_vec, adjoint: <[f64]>::to_vec };
    let largest = sparse_approximation(&identity, &entries, count);
    let places: Vec<_> = largest.into_iter().map(|(index, _)| (index % rows, index / rows)).collect();
    let line = Diagonal::through(&places, rows, columns);
    Mat::from_fn(rows, columns, |i, j| line.distance(i, j).powf(power))
}

/// wᵢⱼ = exp(−σ √(i² + j²)) · distance from the slanted diagonal, i and j counted from 1 \[RCB+17, eq. 12\].
///
/// The spectra share the eigenvalues up to the smaller of their largest ones: r of the sketch's k and s of the mesh's l,
/// one of them all. The diagonal leaves the first entry at s / r rows per column: of a part, whose eigenvalues grow the
/// faster, r < k = rank of C, and s / r = l / r, which Weyl's law says is the ratio of the areas for l = k.
fn slant(sketch: &[f64], mesh: &[f64]) -> Mat<f64> {
    let largest = |spectrum: &[f64]| spectrum.iter().copied().fold(0.0, f64::max);
    let common = largest(sketch).min(largest(mesh));
    let shared = |spectrum: &[f64]| spectrum.iter().filter(|&&eigenvalue| eigenvalue <= common).count().max(1);
    let line = Diagonal { offset: 0.0, slope: shared(mesh) as f64 / shared(sketch) as f64 };
    Mat::from_fn(mesh.len(), sketch.len(), |i, j| {
        let from_corner = ((i + 1) as f64).hypot((j + 1) as f64);
        (-FADING * from_corner).exp() * line.distance(i, j)
    })
}

/// wᵢⱼ = |ρ(μᵢ) − ρ(λⱼ)| over its maximum, μ the mesh's and λ the sketch's eigenvalues \[RPWO19, §4\].
///
/// ρ(λ) = (√λ − i)⁻¹ = √λ / (λ + 1) + i / (λ + 1) is the resolvent at the imaginary unit of the Laplacian to the power
/// ½, eigenvalues in units of the largest of both spectra. With these weights ‖W ⊙ C‖²_F is, but for a factor, the
/// failure of C to commute with the resolvents; the mask of the paper is W ⊙ W.
fn resolvent(sketch: &[f64], mesh: &[f64]) -> Mat<f64> {
    let largest = sketch.iter().chain(mesh).copied().fold(f64::MIN_POSITIVE, f64::max);
    let parts = |eigenvalue: f64| {
        let scaled = eigenvalue.max(0.0) / largest;
        (scaled.sqrt() / (scaled + 1.0), 1.0 / (scaled + 1.0))
    };
    let mut w = Mat::from_fn(mesh.len(), sketch.len(), |i, j| {
        let ((re_mesh, im_mesh), (re_sketch, im_sketch)) = (parts(mesh[i]), parts(sketch[j]));
        (re_mesh - re_sketch).hypot(im_mesh - im_sketch)
    });
    let maximum = w.norm_max();
    if maximum > 0.0 {
        w.col_iter_mut().for_each(|column| column.iter_mut().for_each(|entry| *entry /= maximum));
    }
    w
}

fn sparsity() -> f64 {
    SPARSITY.default
}

fn power() -> f64 {
    POWER.default
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numerics::random;

    /// Eigenvalues after Weyl's law for a shape of this area.
    fn weyl(count: usize, area: f64) -> Vec<f64> {
        (0..count).map(|j| 4.0 * std::f64::consts::PI * j as f64 / area).collect()
    }

    #[test]
    fn cosamp_is_the_power_of_the_distance_from_a_least_squares_line() {
        // Rows 2 + 1.4 · column rounded, in noise; the line is fitted naively through the 16 largest entries.
        let (l, k) = (30, 20);
        let mut c0 = 0.05 * random::normal(l, k, 1);
        (0..k).for_each(|j| c0[((2.0 + 1.4 * j as f64).round() as usize, j)] = 1.0 + 0.01 * j as f64);
        let mut order: Vec<_> = (0..l).flat_map(|i| (0..k).map(move |j| (i, j))).collect();
        order.sort_by(|&a, &b| c0[b].abs().total_cmp(&c0[a].abs()));
        order.truncate(16);
        let mean = |of: fn(&(usize, usize)) -> f64| order.iter().map(of).sum::<f64>() / 16.0;
        let (x, y) = (mean(|place| place.1 as f64), mean(|place| place.0 as f64));
        let moments = order.iter().fold([0.0; 3], |[xx, xy, yy], &(i, j)| {
            let (dx, dy) = (j as f64 - x, i as f64 - y);
            [xx + dx * dx, xy + dx * dy, yy + dy * dy]
        });
        // The angle of the principal axis of the places.
        let slope = (0.5 * (2.0 * moments[1]).atan2(moments[0] - moments[2])).tan();
        let offset = y - slope * x;
        let w = weights(&Weights::Cosamp { sparsity: 0.8, power: 1.2 }, c0.as_ref(), &[], &[]);
        for i in 0..l {
            for j in 0..k {
                let distance = (i as f64 - offset - slope * j as f64).abs() / (1.0 + slope * slope).sqrt();
                assert!((w[(i, j)] - distance.powf(1.2)).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn cosamp_takes_any_c0() {
        let kind = Weights::Cosamp { sparsity: 10.0, power: 1.2 };
        for c0 in [Mat::zeros(4, 6), Mat::ones(1, 1), Mat::ones(3, 2)] {
            let w = weights(&kind, c0.as_ref(), &[], &[]);
            assert_eq!(w.shape(), c0.shape());
            assert!(w.is_all_finite());
        }
    }

    #[test]
    fn the_slant_of_a_part_is_the_ratio_of_the_areas() {
        let (mesh, sketch) = (weyl(20, 2.0), weyl(20, 1.0));
        let w = weights(&Weights::Slant {}, Mat::zeros(20, 20).as_ref(), &sketch, &mesh);
        // r = 10 of the sketch's eigenvalues are at most the mesh's largest: two rows per column.
        assert!((0..10).all(|j| w[(2 * j, j)].abs() < 1e-12));
        assert!(w[(0, 9)] > 1.0);
    }

    #[test]
    fn equal_spectra_have_no_weight_on_the_diagonal() {
        let spectrum = weyl(12, 1.0);
        for kind in [Weights::Slant {}, Weights::Resolvent {}] {
            let w = weights(&kind, Mat::zeros(12, 12).as_ref(), &spectrum, &spectrum);
            for i in 0..12 {
                for j in 0..12 {
                    assert_eq!(w[(i, j)] == 0.0, i == j);
                }
            }
        }
    }

    #[test]
    fn the_resolvent_weights_are_the_commutator_with_the_resolvents() {
        let (mesh, sketch, c) = (weyl(7, 1.7), weyl(5, 1.0), random::normal(7, 5, 2));
        let w = weights(&Weights::Resolvent {}, c.as_ref(), &sketch, &mesh);
        assert_eq!((w.shape(), w.norm_max()), ((7, 5), 1.0));
        // Naively: 1 / (√λ − i) in complex numbers.
        let largest = sketch[4].max(mesh[6]);
        let entry = |i: usize, j: usize| {
            let (u, v) = ((mesh[i] / largest).sqrt(), (sketch[j] / largest).sqrt());
            // 1/(u − i) − 1/(v − i) = (v − u) / ((u − i)(v − i))
            (v - u).abs() / ((u * u + 1.0).sqrt() * (v * v + 1.0).sqrt())
        };
        let maximum = (0..7).flat_map(|i| (0..5).map(move |j| entry(i, j))).fold(0.0, f64::max);
        for i in 0..7 {
            for j in 0..5 {
                assert!((w[(i, j)] - entry(i, j) / maximum).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn parameters_out_of_range_are_named() {
        let fields = |kind: &Weights| faults(kind).into_iter().map(|(field, _)| field).collect::<Vec<_>>();
        assert_eq!(fields(&Weights::Cosamp { sparsity: 0.0, power: -1.0 }), ["sparsity", "power"]);
        assert_eq!(fields(&Weights::Cosamp { sparsity: f64::NAN, power: 1.2 }), ["sparsity"]);
        assert!(fields(&Weights::Cosamp { sparsity: 10.0, power: 0.0 }).is_empty());
        let defaults: Weights = serde_json::from_str(r#"{"method": "cosamp"}"#).unwrap();
        assert_eq!(defaults, Weights::Cosamp { sparsity: 0.8, power: 1.2 });
        assert_eq!((SPARSITY.default, POWER.default), (0.8, 1.2));
    }
}
