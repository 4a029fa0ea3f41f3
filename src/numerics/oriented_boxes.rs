//! Boxes around patches of rows, turned to lie along them.
//!
//! A patch of a surface is nearly flat, however many dimensions it lies in: a few axes hold nearly all of it. A box is
//! its centre c, orthonormal axes u_i with the interval of (ψ − c)·u_i over its rows ψ, and the radius ρ of what the
//! axes leave. What a point is to the whole box is then told by its products with c and the u_i.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};

use super::lanes::{self, Kernel, Lanes};
use super::patched_rows::{self, Column, PATCH, PatchedRows};

/// Axes of a box: two along the surface and one for its bend.
const AXES: usize = 3;

/// Products of a point with a box: with its centre and with its axes.
const PRODUCTS: usize = 1 + AXES;

/// An axis along which a patch reaches less than this share of its radius is left out: it would be made of rounding.
const FLAT: f64 = 1e-3;

/// What is reckoned here is rounded by less than this share of the squared lengths in it, per dimension: several
/// hundred times the unit roundoff.
const ROUNDING: f64 = 1e-13;

/// Boxes around all patches of rows in their first d columns.
pub struct OrientedBoxes {
    /// d × 4 boxes: all centres, all first axes, all second, …
    directions: Mat<f64>,
    /// ‖c‖² per box.
    squared_centre: Vec<f64>,
    axes: [Axis; AXES],
    /// ρ per box.
    rest: Vec<f64>,
    /// The length of the longest row per box.
    longest: Vec<f64>,
}

/// Per box: u·c, and the ends of u·(ψ − c).
#[derive(Default)]
struct Axis {
    centre: Vec<f64>,
    low: Vec<f64>,
    high: Vec<f64>,
}

impl Axis {
    /// The fields, n each.
    #[inline(always)]
    fn cut(&self, n: usize) -> (&[f64], &[f64], &[f64]) {
        (&self.centre[..n], &self.low[..n], &self.high[..n])
    }
}

impl OrientedBoxes {
    /// The boxes around the first `columns` columns of `rows`.
    pub fn around(rows: &PatchedRows, columns: usize) -> OrientedBoxes {
        let patches = rows.patches();
        let mut boxes = OrientedBoxes {
            directions: Mat::zeros(columns, PRODUCTS * patches),
            squared_centre: Vec::with_capacity(patches),
            axes: Default::default(),
            rest: Vec::with_capacity(patches),
            longest: Vec::with_capacity(patches),
        };
        for patch in 0..patches {
            boxes.enclose(patch, patches, &rows.patch(patch)[..columns], rows.rows(patch).len());
        }
        boxes
    }

    /// Adds the box of a patch of `count` rows.
    fn enclose(&mut self, patch: usize, patches: usize, columns: &[Column], count: usize) {
        let centre: Vec<f64> =
            columns.iter().map(|column| column[..count].iter().sum::<f64>() / count as f64).collect();
        let largest = |squares: &Column| squares[..count].iter().fold(0.0, |a, &b| larger(b, a));
        let mut left = patched_rows::squared_distances(columns, &centre);
        let radius = largest(&left).sqrt();
        for i in 0..AXES {
            // Towards the row that is farthest from what the axes so far hold.
            let farthest = (0..count).max_by(|&a, &b| left[a].total_cmp(&left[b])).unwrap_or(0);
            let direction = columns.iter().zip(&centre).map(|(column, c)| column[farthest] - c).collect();
            let before = (1..=i).map(|part| self.directions.col_as_slice(part * patches + patch));
            let direction = perpendicular(direction, before, FLAT * radius);
            let offset: f64 = centre.iter().zip(&direction).map(|(c, u)| c * u).sum();
            let along = patched_rows::products(columns, &direction).map(|product| product - offset);
            for (left, along) in left.iter_mut().zip(&along) {
                *left -= along * along;
            }
            self.axes[i].centre.push(offset);
            self.axes[i].low.push(along[..count].iter().fold(f64::INFINITY, |a, &b| a.min(b)));
            self.axes[i].high.push(along[..count].iter().fold(f64::NEG_INFINITY, |a, &b| a.max(b)));
            self.directions.col_as_slice_mut((1 + i) * patches + patch).copy_from_slice(&direction);
        }
        let squared_centre = centre.iter().map(|c| c * c).sum::<f64>();
        let longest = squared_centre.sqrt() + radius;
        self.rest.push((larger(largest(&left), 0.0) + self.rounding() * longest * longest).sqrt());
        self.longest.push(longest);
        self.squared_centre.push(squared_centre);
        self.directions.col_as_slice_mut(patch).copy_from_slice(&centre);
    }

    /// Number of boxes.
    pub fn count(&self) -> usize {
        self.rest.len()
    }

    /// The products of `points` (d × m) with all centres and axes (4 boxes × m), for the bounds.
    pub fn products(&self, points: MatRef<'_, f64>) -> Mat<f64> {
        let mut products = Mat::zeros(self.directions.ncols(), points.ncols());
        matmul(products.as_mut(), Accum::Replace, self.directions.transpose(), points, 1.0, Par::Seq);
        products
    }

    /// A number per box, that no computed ‖p − ψ‖² with a row ψ in the box is below; `products` are those of p and
    /// `squared` = ‖p‖².
    pub fn least_squared_distances(&self, products: &[f64], squared: f64, bounds: &mut [f64]) {
        lanes::run(LeastSquaredDistances { boxes: self, products, squared, bounds });
    }

    /// A number per box, that no computed −p·ψ with a row ψ in the box is below.
    pub fn least_negated_products(&self, products: &[f64], squared: f64, bounds: &mut [f64]) {
        lanes::run(LeastNegatedProducts { boxes: self, products, squared, bounds });
    }

    /// More than what a measure of a row in a box and a point of squared length `squared` is rounded by, in whatever order
    /// it is summed.
    pub fn margin(&self, patch: usize, squared: f64) -> f64 {
        margin(self.rounding(), squared.sqrt() + self.longest[patch])
    }

    /// The rounding of sums of so many terms, as a share of the squared lengths in them.
    fn rounding(&self) -> f64 {
        ROUNDING * (self.directions.nrows() + PATCH) as f64
    }
}

/// The part of `direction` at right angles to the unit vectors `others`, of length 1; 0 where it is not longer than
/// `least`.
fn perpendicular<'a>(mut direction: Vec<f64>, others: impl Iterator<Item = &'a [f64]>, least: f64) -> Vec<f64> {
    for other in others {
        let along: f64 = direction.iter().zip(other).map(|(d, u)| d * u).sum();
        direction.iter_mut().zip(other).for_each(|(d, u)| *d -= along * u);
    }
    let length = direction.iter().map(|d| d * d).sum::<f64>().sqrt();
    let scale = if length > least { 1.0 / length } else { 0.0 };
    direction.iter_mut().for_each(|d| *d *= scale);
    direction
}

/// More than what a bound and the number it bounds are rounded by, for two vectors whose lengths sum to `reach`.
///
/// It overflows before anything it is taken from does, and is above what underflow takes away.
#[inline(always)]
fn margin(rounding: f64, reach: f64) -> f64 {
    rounding * ((2.0 * reach) * (2.0 * reach)) + f64::MIN_POSITIVE
}

struct LeastSquaredDistances<'a> {
    boxes: &'a OrientedBoxes,
    products: &'a [f64],
    squared: f64,
    bounds: &'a mut [f64],
}

impl Kernel for LeastSquaredDistances<'_> {
    #[inline(always)]
    fn compute<L: Lanes>(self, _: L) {
        let LeastSquaredDistances { boxes, products, squared, bounds } = self;
        let n = bounds.len();
        let [with_centre, with_axes @ ..] = per_box(products, n);
        let axes = boxes.axes.each_ref().map(|axis| axis.cut(n));
        let (length, unit) = (squared.sqrt(), boxes.rounding());
        let (squared_centre, rest, longest) = (&boxes.squared_centre[..n], &boxes.rest[..n], &boxes.longest[..n]);
        for b in 0..n {
            let margin = margin(unit, length + longest[b]);
            let mut across = squared - 2.0 * with_centre[b] + squared_centre[b];
            let mut gaps = 0.0;
            for i in 0..AXES {
                let q = with_axes[i][b] - axes[i].0[b];
                let gap = larger(larger(axes[i].1[b] - q, q - axes[i].2[b]), 0.0);
                gaps += gap * gap;
                across -= q * q;
            }
            let gap = larger(larger(across - margin, 0.0).sqrt() - rest[b], 0.0);
            // What is not a number, by overflow, bounds nothing.
            bounds[b] = larger(gaps + gap * gap - margin, f64::NEG_INFINITY);
        }
    }
}

struct LeastNegatedProducts<'a> {
    boxes: &'a OrientedBoxes,
    products: &'a [f64],
    squared: f64,
    bounds: &'a mut [f64],
}

impl Kernel for LeastNegatedProducts<'_> {
    #[inline(always)]
    fn compute<L: Lanes>(self, _: L) {
        let LeastNegatedProducts { boxes, products, squared, bounds } = self;
        let n = bounds.len();
        let [with_centre, with_axes @ ..] = per_box(products, n);
        let axes = boxes.axes.each_ref().map(|axis| axis.cut(n));
        let (length, unit) = (squared.sqrt(), boxes.rounding());
        let (rest, longest) = (&boxes.rest[..n], &boxes.longest[..n]);
        for b in 0..n {
            let margin = margin(unit, length + longest[b]);
            let (mut across, mut most) = (squared, with_centre[b]);
            for i in 0..AXES {
                let q = with_axes[i][b];
                most += larger(q * axes[i].1[b], q * axes[i].2[b]);
                across -= q * q;
            }
            most += larger(across + margin, 0.0).sqrt() * rest[b];
            bounds[b] = larger(-most - margin, f64::NEG_INFINITY);
        }
    }
}

/// The products of one point, apart: with all centres, all first axes, …; n each.
#[inline(always)]
fn per_box(products: &[f64], n: usize) -> [&[f64]; PRODUCTS] {
    std::array::from_fn(
        #[inline(always)]
        |part| &products[part * n..(part + 1) * n],
    )
}

/// The larger of two numbers; the second where one is not a number.
#[inline(always)]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}
