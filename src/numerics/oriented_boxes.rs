//! Boxes around patches of rows, turned to lie along them.
//!
//! A patch of a surface is nearly flat, however many dimensions it lies in: a few axes hold nearly all of it. A box is
//! its centre c, orthonormal axes u_i with the interval of (ψ − c)·u_i over its rows ψ, and the radius ρ of what the
//! axes leave. What a point is to the whole box is then told by its products with c and the u_i.

use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, MatRef, Par};

use super::lanes::vectorised;
use super::patched_rows::{self, Column, PATCH, PatchedRows};

/// Axes of a box: two along the surface and one for its bend.
const AXES: usize = 3;

/// Products of a point with a box: with its centre and with its axes.
const PRODUCTS: usize = 1 + AXES;

/// An axis along which a patch reaches less than this share of its radius is left out: it would be made of rounding.
const FLAT: f64 = 1e-3;

/// Bounds are reckoned in single precision, which takes half the time. A bound and what it bounds are rounded by less than
/// 8 (d + 6) of its units roundoff, times the square of ‖p‖ + ‖ψ‖: products of d terms by d + 3 of them, squares of
/// three such by 6 (d + 4), three gaps by 6 (d + 6), and a few more.
const ROUNDING: f32 = 4.0 * f32::EPSILON;

/// More than what products and sums of squares of any length lose where they are too small for single precision.
const UNDERFLOW: f32 = 1e4 * f32::MIN_POSITIVE;

/// What the squares that axes leave are rounded by in double precision, as a share of the squared lengths, per dimension:
/// several hundred times the unit roundoff.
const LEFT: f64 = 1e-13;

/// Boxes around all patches of rows in their first d columns.
pub struct OrientedBoxes {
    /// d × 4 boxes: all centres, all first axes, all second, …
    directions: Mat<f32>,
    /// ‖c‖² per box.
    squared_centre: Vec<f32>,
    axes: [Axis; AXES],
    /// ρ per box, or a little more.
    rest: Vec<f32>,
    /// The length of the longest row per box.
    longest: Vec<f32>,
}

/// Per box: u·c, and the ends of u·(ψ − c).
#[derive(Default)]
struct Axis {
    centre: Vec<f32>,
    low: Vec<f32>,
    high: Vec<f32>,
}

impl Axis {
    /// The fields, n each.
    #[inline(always)]
    fn cut(&self, n: usize) -> (&[f32], &[f32], &[f32]) {
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
        let largest = |squares: &Column| squares[..count].iter().fold(0.0f64, |a, &b| a.max(b));
        let mut left = patched_rows::squared_distances(columns, &centre);
        let radius = largest(&left).sqrt();
        let mut directions: Vec<Vec<f64>> = Vec::with_capacity(AXES);
        for axis in &mut self.axes {
            // Towards the row that is farthest from what the axes so far hold.
            let farthest = (0..count).max_by(|&a, &b| left[a].total_cmp(&left[b])).unwrap_or(0);
            let direction = columns.iter().zip(&centre).map(|(column, c)| column[farthest] - c).collect();
            let direction = perpendicular(direction, &directions, FLAT * radius);
            let offset: f64 = centre.iter().zip(&direction).map(|(c, u)| c * u).sum();
            let along = patched_rows::products(columns, &direction).map(|product| product - offset);
            for (left, along) in left.iter_mut().zip(&along) {
                *left -= along * along;
            }
            axis.centre.push(offset as f32);
            axis.low.push(along[..count].iter().fold(f64::INFINITY, |a, &b| a.min(b)) as f32);
            axis.high.push(along[..count].iter().fold(f64::NEG_INFINITY, |a, &b| a.max(b)) as f32);
            directions.push(direction);
        }
        let squared_centre = centre.iter().map(|c| c * c).sum::<f64>();
        let longest = squared_centre.sqrt() + radius;
        let rounding = LEFT * (columns.len() + PATCH) as f64 * longest * longest;
        self.rest.push(above((largest(&left) + rounding).sqrt()));
        self.longest.push(above(longest));
        self.squared_centre.push(squared_centre as f32);
        for (part, direction) in [centre].iter().chain(&directions).enumerate() {
            let to = self.directions.col_as_slice_mut(part * patches + patch);
            to.iter_mut().zip(direction).for_each(|(to, &x)| *to = x as f32);
        }
    }

    /// Number of boxes.
    pub fn count(&self) -> usize {
        self.rest.len()
    }

    /// The products of `points` (d × m) with all centres and axes (4 boxes × m), for the bounds.
    pub fn products(&self, points: MatRef<'_, f32>) -> Mat<f32> {
        let mut products = Mat::zeros(self.directions.ncols(), points.ncols());
        matmul(products.as_mut(), Accum::Replace, self.directions.transpose(), points, 1.0, Par::Seq);
        products
    }

    /// A number per box, that no computed ‖p − ψ‖² with a row ψ in the box is below; `products` are those of p and
    /// `squared` = ‖p‖².
    pub fn least_squared_distances(&self, products: &[f32], squared: f32, bounds: &mut [f32]) {
        vectorised(
            #[inline(always)]
            || self.below_squared_distances(products, squared, bounds),
        );
    }

    /// A number per box, that no computed −p·ψ with a row ψ in the box is below.
    pub fn least_negated_products(&self, products: &[f32], squared: f32, bounds: &mut [f32]) {
        vectorised(
            #[inline(always)]
            || self.below_negated_products(products, squared, bounds),
        );
    }

    /// More than what a measure of a row in a box and a point of squared length `squared` is rounded by in single precision.
    pub fn margin(&self, patch: usize, squared: f32) -> f32 {
        margin(self.rounding(), squared.sqrt() + self.longest[patch])
    }

    /// What numbers are rounded by, as a share of the squared lengths in them.
    #[inline(always)]
    fn rounding(&self) -> f32 {
        ROUNDING * (self.directions.nrows() + 6) as f32
    }

    #[inline(always)]
    fn below_squared_distances(&self, products: &[f32], squared: f32, bounds: &mut [f32]) {
        let n = bounds.len();
        let [with_centre, with_axes @ ..] = per_box(products, n);
        let axes = self.axes.each_ref().map(
            #[inline(always)]
            |axis| axis.cut(n),
        );
        let (length, unit) = (squared.sqrt(), self.rounding());
        let (squared_centre, rest, longest) = (&self.squared_centre[..n], &self.rest[..n], &self.longest[..n]);
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
            bounds[b] = larger(gaps + gap * gap - margin, f32::NEG_INFINITY);
        }
    }

    #[inline(always)]
    fn below_negated_products(&self, products: &[f32], squared: f32, bounds: &mut [f32]) {
        let n = bounds.len();
        let [with_centre, with_axes @ ..] = per_box(products, n);
        let axes = self.axes.each_ref().map(
            #[inline(always)]
            |axis| axis.cut(n),
        );
        let (length, unit) = (squared.sqrt(), self.rounding());
        let (rest, longest) = (&self.rest[..n], &self.longest[..n]);
        for b in 0..n {
            let margin = margin(unit, length + longest[b]);
            let (mut across, mut most) = (squared, with_centre[b]);
            for i in 0..AXES {
                let q = with_axes[i][b];
                most += larger(q * axes[i].1[b], q * axes[i].2[b]);
                across -= q * q;
            }
            most += larger(across + margin, 0.0).sqrt() * rest[b];
            bounds[b] = larger(-most - margin, f32::NEG_INFINITY);
        }
    }
}

/// The part of `direction` at right angles to the unit vectors `others`, of length 1; 0 where it is not longer than
/// `least`.
fn perpendicular(mut direction: Vec<f64>, others: &[Vec<f64>], least: f64) -> Vec<f64> {
    for other in others {
        let along: f64 = direction.iter().zip(other).map(|(d, u)| d * u).sum();
        direction.iter_mut().zip(other).for_each(|(d, u)| *d -= along * u);
    }
    let length = direction.iter().map(|d| d * d).sum::<f64>().sqrt();
    let scale = if length > least { 1.0 / length } else { 0.0 };
    direction.iter_mut().for_each(|d| *d *= scale);
    direction
}

/// Not less, in single precision.
fn above(value: f64) -> f32 {
    (value as f32) * (1.0 + f32::EPSILON) + f32::MIN_POSITIVE
}

/// More than what a bound and the number it bounds are rounded by, for two vectors whose lengths sum to `reach`.
///
/// It overflows before anything it is taken from does, and is above what underflow takes away.
#[inline(always)]
fn margin(rounding: f32, reach: f32) -> f32 {
    rounding * (reach * reach) + UNDERFLOW
}

/// The products of one point, apart: with all centres, all first axes, …; n each.
#[inline(always)]
fn per_box(products: &[f32], n: usize) -> [&[f32]; PRODUCTS] {
    std::array::from_fn(
        #[inline(always)]
        |part| &products[part * n..(part + 1) * n],
    )
}

/// The larger of two numbers; the second where one is not a number.
#[inline(always)]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}
