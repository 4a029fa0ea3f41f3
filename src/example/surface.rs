//! The surface of an implicit body as triangles.

use fast_surface_nets::ndshape::{RuntimeShape, Shape};
use fast_surface_nets::{SurfaceNetsBuffer, surface_nets};

use super::body::Body;
use crate::mesh::{dot, length, subtract};

/// Cells along the longest side of the trial grid that tells how many vertices a spacing gives.
const TRIAL_CELLS: f64 = 48.0;
/// Rounds of tangential smoothing.
const ROUNDS: usize = 12;

/// Positions and triangles of the posed body: closed, wound outwards, about `vertices` vertices.
pub(super) fn triangles(body: &Body, vertices: usize) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let [low, high] = body.bounds();
    let trial = (0..3).map(|i| high[i] - low[i]).fold(0.0, f64::max) / TRIAL_CELLS;
    // The number of vertices grows with the inverse square of the spacing.
    let spacing = trial * (net(body, trial).0.len() as f64 / vertices as f64).sqrt();
    let (mut positions, triangles) = net(body, spacing);
    for _ in 0..ROUNDS {
        smooth(body, &mut positions, &triangles);
    }
    (positions.into_iter().map(|p| body.posed(p)).collect(), triangles)
}

/// The surface net of the body at rest on a cubic grid that is its own mirror image in the plane x = 0.
fn net(body: &Body, spacing: f64) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let [low, high] = body.bounds();
    let cells: [u32; 3] = std::array::from_fn(|i| ((high[i] - low[i]) / spacing).ceil() as u32 + 2);
    let origin: [f64; 3] = std::array::from_fn(|i| 0.5 * (low[i] + high[i] - f64::from(cells[i]) * spacing));
    let place = |grid: [f64; 3]| std::array::from_fn(|i| origin[i] + spacing * grid[i]);
    let shape = RuntimeShape::<u32, 3>::new(cells.map(|n| n + 1));
    let samples: Vec<f32> =
        (0..shape.size()).map(|i| body.field(place(shape.delinearize(i).map(f64::from))) as f32).collect();
    let mut buffer = SurfaceNetsBuffer::default();
    surface_nets(&samples, &shape, [0; 3], cells, &mut buffer);
    let positions = buffer.positions.iter().map(|p| place(p.map(f64::from))).collect();
    let triangles = buffer.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    (positions, triangles)
}

/// Moves every vertex along the surface half way to the mean of its neighbours, then back onto the surface.
fn smooth(body: &Body, positions: &mut [[f64; 3]], triangles: &[[u32; 3]]) {
    let mut sums = vec![([0.0; 3], 0.0); positions.len()];
    for &[a, b, c] in triangles {
        for (vertex, neighbour) in [(a, b), (b, c), (c, a)] {
            // Every edge has two triangles, which run along it in both directions.
            let (sum, count) = &mut sums[vertex as usize];
            *sum = std::array::from_fn(|i| sum[i] + positions[neighbour as usize][i]);
            *count += 1.0;
        }
    }
    for (p, (sum, count)) in positions.iter_mut().zip(sums) {
        let pull = subtract(sum.map(|s| s / count), *p);
        let gradient = body.gradient(*p);
        let normal = gradient.map(|g| g / length(gradient));
        let lift = dot(pull, normal);
        *p = std::array::from_fn(|i| p[i] + 0.5 * (pull[i] - lift * normal[i]));
        *p = nearer(body, nearer(body, *p));
    }
}

/// One Newton step towards the surface.
fn nearer(body: &Body, p: [f64; 3]) -> [f64; 3] {
    let gradient = body.gradient(p);
    let step = body.field(p) / dot(gradient, gradient);
    std::array::from_fn(|i| p[i] - step * gradient[i])
}
