//! The surface of an implicit body as triangles.

use fast_surface_nets::ndshape::{RuntimeShape, Shape};
use fast_surface_nets::{SurfaceNetsBuffer, surface_nets};

use super::body::Body;
use crate::geometry::{dot, subtract};

/// Cells along the longest side of the first grid, which tells how many vertices a spacing gives.
const TRIAL_CELLS: f64 = 48.0;
/// Grids after the first.
const REFINEMENTS: usize = 2;
/// Rounds of tangential smoothing.
const ROUNDS: usize = 10;

/// Positions and triangles of the posed body: closed, wound outwards, about `vertices` vertices.
pub(super) fn triangles(body: &Body, vertices: usize) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let [low, high] = body.bounds();
    let mut spacing = (0..3).map(|i| high[i] - low[i]).fold(0.0, f64::max) / TRIAL_CELLS;
    let (mut positions, mut triangles) = net(body, spacing);
    for _ in 0..REFINEMENTS {
        // The number of vertices grows with the inverse square of the spacing.
        spacing *= (positions.len() as f64 / vertices as f64).sqrt();
        (positions, triangles) = net(body, spacing);
    }
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
    let mut samples: Vec<f32> =
        (0..shape.size()).map(|i| body.field(place(shape.delinearize(i).map(f64::from))) as f32).collect();
    fill_alternating_faces(&mut samples, &shape);
    let mut buffer = SurfaceNetsBuffer::default();
    surface_nets(&samples, &shape, [0; 3], cells, &mut buffer);
    let positions = buffer.positions.iter().map(|p| place(p.map(f64::from))).collect();
    let triangles = buffer.indices.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
    (positions, triangles)
}

/// Takes all corners of a grid face inside where inside and outside alternate around it, so that no edge of the net has
/// four triangles. This happens where a limb reaches only just through a plane of the grid; the sliver of space that is
/// added goes again when the vertices are moved onto the surface.
fn fill_alternating_faces(samples: &mut [f32], shape: &RuntimeShape<u32, 3>) {
    let [x, y, z] = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map(|step| shape.linearize(step) as usize);
    let faces = [[0, x, y, x + y], [0, y, z, y + z], [0, z, x, z + x]];
    let mut filled = true;
    // Every round takes samples inside and none out: the rounds end.
    while filled {
        filled = false;
        for (corner, face) in (0..samples.len()).flat_map(|corner| faces.map(|face| (corner, face))) {
            // Faces that wrap around the border of the grid lie outside altogether, as the border does.
            let Some([a, b, c, d]) = samples.get(corner..=corner + face[3]).map(|s| face.map(|i| s[i] < 0.0)) else {
                continue;
            };
            if a == d && b == c && a != b {
                for sample in face.map(|i| corner + i) {
                    samples[sample] = -samples[sample].abs().max(f32::MIN_POSITIVE);
                }
                filled = true;
            }
        }
    }
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
        let (_, gradient) = body.slope(*p);
        let lift = dot(pull, gradient) / dot(gradient, gradient);
        *p = nearer(body, std::array::from_fn(|i| p[i] + 0.5 * (pull[i] - lift * gradient[i])));
    }
}

/// One Newton step towards the surface.
fn nearer(body: &Body, p: [f64; 3]) -> [f64; 3] {
    let (height, gradient) = body.slope(p);
    let step = height / dot(gradient, gradient);
    std::array::from_fn(|i| p[i] - step * gradient[i])
}
