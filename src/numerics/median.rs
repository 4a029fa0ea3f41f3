//! The value in the middle.

/// The middle value, of an even number the upper one; 0 of none.
pub fn median(mut values: Vec<f64>) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_median_is_the_upper_middle_one() {
        assert_eq!([median(vec![3.0, 1.0, 2.0]), median(vec![1.0, 2.0]), median(Vec::new())], [2.0, 2.0, 0.0]);
    }
}
