//! What many errors come to.

use serde::{Deserialize, Serialize};
use utoipa::ToSchema;

/// The largest error that the curve shows, in its units; beyond it nothing is told apart.
const LAST_THRESHOLD: f64 = 0.5;
/// Steps of the curve.
const STEPS: usize = 50;
/// Errors up to which a share is told by itself.
const LIMITS: [f64; 3] = [0.05, 0.1, 0.2];

/// What some errors come to; those that are not known are left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Measures {
    /// How many errors are known.
    pub count: usize,
    /// Null where there is none, or one is infinite.
    #[schema(value_type = Option<f64>)]
    #[serde(deserialize_with = "unbounded")]
    pub mean: f64,
    /// Null where there is none, or half are infinite.
    #[schema(value_type = Option<f64>)]
    #[serde(deserialize_with = "unbounded")]
    pub median: f64,
    /// Mean of the curve: 1 where there are no errors.
    pub auc: f64,
    /// Shares of the errors at or below some limits.
    pub within: Vec<Within>,
    /// The share of errors at or below each threshold.
    pub curve: Vec<f64>,
}

/// A share of errors at or below a limit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
#[schema(as = WithinLimit)]
pub struct Within {
    pub limit: f64,
    pub share: f64,
}

impl Measures {
    /// The measures of errors; what is not a number is not known.
    pub fn of(errors: &[f64]) -> Measures {
        let curve = curve(errors, &thresholds());
        let within = LIMITS.into_iter().zip(self::curve(errors, &LIMITS));
        Measures {
            count: known(errors).count(),
            mean: mean(errors),
            median: median(errors),
            auc: mean(&curve),
            within: within.map(|(limit, share)| Within { limit, share }).collect(),
            curve,
        }
    }

    /// The share of errors at or below one of the limits; not a number where it is none.
    pub fn share_within(&self, limit: f64) -> f64 {
        self.within.iter().find(|within| within.limit == limit).map_or(f64::NAN, |within| within.share)
    }
}

/// JSON has no infinity: where null was written the number is not known to be finite.
pub(super) fn unbounded<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Ok(Option::<f64>::deserialize(deserializer)?.unwrap_or(f64::INFINITY))
}

/// The thresholds of the curve: 0 to 0.5 in steps of 0.01.
pub fn thresholds() -> Vec<f64> {
    (0..=STEPS).map(|i| LAST_THRESHOLD * i as f64 / STEPS as f64).collect()
}

fn known(errors: &[f64]) -> impl Iterator<Item = f64> {
    errors.iter().copied().filter(|error| !error.is_nan())
}

/// The mean of the errors that are known; not a number of none.
pub fn mean(errors: &[f64]) -> f64 {
    let (sum, count) = known(errors).fold((0.0, 0.0), |(sum, count), error| (sum + error, count + 1.0));
    sum / count
}

/// The middle one of the errors that are known, the mean of two where there are two; not a number of none.
fn median(errors: &[f64]) -> f64 {
    let mut sorted: Vec<f64> = known(errors).collect();
    sorted.sort_unstable_by(f64::total_cmp);
    match sorted.len() {
        0 => f64::NAN,
        n if n % 2 == 1 => sorted[n / 2],
        n => 0.5 * (sorted[n / 2 - 1] + sorted[n / 2]),
    }
}

/// The share of the errors that are known at or below each threshold; 0 where none is.
pub fn curve(errors: &[f64], thresholds: &[f64]) -> Vec<f64> {
    let count = known(errors).count().max(1) as f64;
    thresholds.iter().map(|&t| known(errors).filter(|&error| error <= t).count() as f64 / count).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_counts_errors_at_and_below_the_threshold() {
        let errors = [0.0, 0.1, f64::NAN, 0.3, f64::INFINITY];
        assert_eq!(curve(&errors, &[0.0, 0.1, 0.2, 0.5]), [0.25, 0.5, 0.5, 0.75]);
        assert_eq!(mean(&errors[..3]), 0.05);
        assert_eq!(curve(&[f64::NAN], &[0.5]), [0.0]);
    }

    #[test]
    fn the_measures_are_those_of_what_is_known() {
        let measures = Measures::of(&[0.0, f64::NAN, 0.02, 0.25, 0.06]);
        assert_eq!((measures.count, measures.median), (4, 0.04));
        assert!((measures.mean - 0.0825).abs() < 1e-15);
        let shares: Vec<f64> = measures.within.iter().map(|within| within.share).collect();
        assert_eq!(shares, [0.5, 0.75, 0.75]);
        assert_eq!((measures.curve.len(), measures.curve[0], measures.curve[50]), (51, 0.25, 1.0));
        // Of four errors each fills the curve from the first threshold at or above it on: 51, 49, 26 and 45 of 51.
        assert!((measures.auc - (51.0 + 49.0 + 26.0 + 45.0) / 4.0 / 51.0).abs() < 1e-12);
    }

    #[test]
    fn what_cannot_be_reached_is_null_in_json() {
        let measures = Measures::of(&[0.1, f64::INFINITY, f64::INFINITY]);
        let written = serde_json::to_value(&measures).unwrap();
        assert!(written["mean"].is_null() && written["median"].is_null());
        assert_eq!(serde_json::from_value::<Measures>(written).unwrap(), measures);
        assert_eq!(Measures::of(&[0.0, 0.0]).auc, 1.0);
    }
}
