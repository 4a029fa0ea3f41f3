//! Minimisation without derivatives by a simplex [NM65].

/// When the simplex is small enough, and after how many steps it is given up at the latest.
#[derive(Clone, Copy, Debug)]
pub struct Tolerance {
    /// Largest difference of a coordinate to the best corner's.
    pub point: f64,
    /// Largest difference of a value to the best corner's.
    pub value: f64,
    pub steps: usize,
}

/// The best point found and the function's value there. The first simplex is `start` and, for every coordinate, `start`
/// moved by that coordinate of `spread`, which must not be 0. The function may be rough but must not return NaN.
///
/// # Errors
/// That of the function.
pub fn minimum<const N: usize, E>(
    mut function: impl FnMut([f64; N]) -> Result<f64, E>,
    start: [f64; N],
    spread: [f64; N],
    tolerance: Tolerance,
) -> Result<([f64; N], f64), E> {
    let mut simplex = vec![start];
    simplex.extend((0..N).map(|i| {
        let mut corner = start;
        corner[i] += spread[i];
        corner
    }));
    let corners = simplex.into_iter().map(|point| Ok((point, function(point)?)));
    let mut simplex: Vec<([f64; N], f64)> = corners.collect::<Result<_, E>>()?;
    for _ in 0..tolerance.steps {
        // Stable, so that among equals the older stays ahead.
        simplex.sort_by(|a, b| a.1.total_cmp(&b.1));
        if is_small(&simplex, tolerance) {
            break;
        }
        step(&mut function, &mut simplex)?;
    }
    Ok(simplex.into_iter().reduce(|a, b| if b.1 < a.1 { b } else { a }).expect("a simplex has N + 1 corners"))
}

fn is_small<const N: usize>(simplex: &[([f64; N], f64)], tolerance: Tolerance) -> bool {
    let (best, least) = simplex[0];
    simplex[1..].iter().all(|(point, value)| {
        value - least <= tolerance.value && (0..N).all(|i| (point[i] - best[i]).abs() <= tolerance.point)
    })
}

/// Replaces the worst corner of a sorted simplex by one beyond or before the middle of the others, or draws all of them
/// towards the best.
fn step<const N: usize, E>(
    function: &mut impl FnMut([f64; N]) -> Result<f64, E>,
    simplex: &mut [([f64; N], f64)],
) -> Result<(), E> {
    let (best, second, worst) = (simplex[0], simplex[N.saturating_sub(1)], simplex[N]);
    let middle: [f64; N] =
        std::array::from_fn(|i| simplex[..N].iter().map(|corner| corner.0[i]).sum::<f64>() / N as f64);
    let mut at = |share: f64| {
        let point = std::array::from_fn(|i| middle[i] + share * (worst.0[i] - middle[i]));
        Ok((point, function(point)?))
    };
    let reflected = at(-1.0)?;
    if reflected.1 < best.1 {
        let expanded = at(-2.0)?;
        simplex[N] = if expanded.1 < reflected.1 { expanded } else { reflected };
    } else if reflected.1 < second.1 {
        simplex[N] = reflected;
    } else {
        let outside = reflected.1 < worst.1;
        let contracted = at(if outside { -0.5 } else { 0.5 })?;
        if contracted.1 < reflected.1.min(worst.1) {
            simplex[N] = contracted;
        } else {
            for corner in &mut simplex[1..] {
                let point = std::array::from_fn(|i| 0.5 * (best.0[i] + corner.0[i]));
                *corner = (point, function(point)?);
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::*;

    const FINE: Tolerance = Tolerance { point: 1e-9, value: 1e-12, steps: 1000 };

    #[test]
    fn finds_the_bottom_of_a_bent_valley() {
        let valley = |[x, y]: [f64; 2]| Ok::<_, Infallible>((1.0 - x).powi(2) + 100.0 * (y - x * x).powi(2));
        let Ok((point, value)) = minimum(valley, [-1.2, 1.0], [0.1, 0.1], FINE);
        assert!((point[0] - 1.0).abs() < 1e-6 && (point[1] - 1.0).abs() < 1e-6 && value < 1e-11, "{point:?}");
    }

    #[test]
    fn finds_a_kink_in_three_dimensions_and_never_leaves_the_best() {
        let kink = |[x, y, z]: [f64; 3]| (x - 0.3).abs() + 2.0 * (y + 0.2).abs() + (z - x).powi(2);
        let Ok((point, _)) = minimum(|p| Ok::<_, Infallible>(kink(p)), [0.0; 3], [0.15, 0.15, 0.03], FINE);
        assert!((point[0] - 0.3).abs() < 1e-5 && (point[1] + 0.2).abs() < 1e-5, "{point:?}");
        let mut least = f64::INFINITY;
        let watched = |p: [f64; 3]| {
            let value = kink(p);
            least = least.min(value);
            Ok::<_, Infallible>(value)
        };
        let Ok((_, value)) = minimum(watched, [0.0; 3], [0.15, 0.15, 0.03], Tolerance { steps: 25, ..FINE });
        assert_eq!(value, least);
    }

    #[test]
    fn it_ends_where_the_function_does() {
        let mut left = 5;
        let failing = |p: [f64; 2]| {
            left -= 1;
            if left > 0 { Ok(p[0].abs() + p[1].abs()) } else { Err("stop") }
        };
        assert_eq!(minimum(failing, [1.0; 2], [0.1; 2], FINE), Err("stop"));
    }
}
