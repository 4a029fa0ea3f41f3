//! Corresponding regions made of a truth, in place of a hand that pairs them.

use super::truth::Truth;
use crate::correspondence::inverse;
use crate::mesh::TriangleMesh;
use crate::mesh::farthest_points::FarthestPoints;
use crate::mesh::file_mesh::FileMesh;
use crate::mesh::geodesics::Marching;
use crate::numerics::Unwatched;
use crate::regions::Regions;

/// Labels of the vertices of a sketch and of a mesh's file: `count` geodesic cells of the truth's points, whose
/// seeds are the point that is farthest from another and then the farthest from those before. `at` are the places of the sketch's
/// vertices in the truth's coordinates.
///
/// Of a view from the side the far side of the mesh is in no region, else front and back are in that of their point.
///
/// # Panics
/// Where the truth has [faults](Truth::faults) for the mesh.
pub fn of_truth(
    truth: &Truth,
    count: usize,
    (flat, at): (&TriangleMesh, &[[f64; 2]]),
    mesh: &FileMesh,
) -> [Vec<i32>; 2] {
    let vertices: Vec<u32> = truth.answers(at, &(0..at.len() as u32).collect::<Vec<_>>());
    let plane = Marching::new(flat);
    let cells = cells(&plane, &vertices, count);
    let labelled = |cell: Option<usize>| cell.map_or(Regions::NONE, |point| cells[point] as i32);
    let sketch = plane
        .cells_within(&vertices, f64::INFINITY, &Unwatched)
        .expect("nobody says stop")
        .into_iter()
        .map(labelled)
        .collect();

    let variants: &[&str] = if truth.side { &["front"] } else { &["front", "back"] };
    let known = |variant: &&str| {
        let vertices = truth.variants.get(*variant).into_iter().flatten().enumerate();
        vertices.filter_map(|(point, &vertex)| Some((point, mesh.sound_vertices(u32::try_from(vertex).ok()?).next()?)))
    };
    let (points, sources): (Vec<usize>, Vec<u32>) = variants.iter().flat_map(known).unzip();
    let near = inverse::of_points(mesh.sound(), &sources, &Unwatched).expect("nobody says stop");
    let of_file = |vertex: u32| mesh.sound_vertices(vertex).next().and_then(|own| near[own as usize]);
    let solid = (0..mesh.positions().len() as u32).map(|v| labelled(of_file(v).map(|source| points[source]))).collect();
    [sketch, solid]
}

/// For every one of these vertices the cell it is in, of `count`.
fn cells(plane: &Marching, vertices: &[u32], count: usize) -> Vec<usize> {
    let away: Vec<Vec<f64>> = vertices
        .iter()
        .map(|&v| {
            let distances = plane.distances(&[v], &Unwatched).expect("nobody says stop");
            vertices.iter().map(|&w| distances[w as usize]).collect()
        })
        .collect();
    let reach = |point: &usize| away[*point].iter().copied().fold(0.0, f64::max);
    let Some(first) = (0..vertices.len()).max_by(|a, b| reach(a).total_cmp(&reach(b)).then(b.cmp(a))) else {
        return Vec::new();
    };
    let mut spread = FarthestPoints::new(vertices.len());
    let mut seeds = vec![first];
    spread.choose(&away[first]);
    while seeds.len() < count.min(vertices.len()) {
        let Some(next) = spread.farthest(0..vertices.len() as u32) else { break };
        seeds.push(next as usize);
        spread.choose(&away[next as usize]);
    }
    let nearest = |point: usize| {
        let cell = (0..seeds.len()).min_by(|&a, &b| away[seeds[a]][point].total_cmp(&away[seeds[b]][point]));
        cell.unwrap_or(0)
    };
    (0..vertices.len()).map(nearest).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::solids::sheet;

    #[test]
    fn regions_of_a_sheet_matched_to_itself_are_the_same_on_both() {
        let flat = sheet(10, 10);
        let at: Vec<[f64; 2]> = flat.positions().iter().map(|p| [p[0], p[1]]).collect();
        let every_third: Vec<usize> = (0..at.len()).step_by(3).collect();
        let truth = Truth {
            side: true,
            points: every_third.iter().map(|&v| at[v]).collect(),
            variants: [("front".to_owned(), every_third.iter().map(|&v| v as i64).collect())].into(),
        };
        let [sketch, mesh] = of_truth(&truth, 4, (&flat, &at), &flat.clone().into());
        let kinds: std::collections::BTreeSet<i32> = sketch.iter().copied().collect();
        assert_eq!(kinds.into_iter().collect::<Vec<_>>(), [0, 1, 2, 3]);
        assert_eq!(sketch, mesh);
        // The corners are farthest from each other and in regions of their own.
        let corners: std::collections::BTreeSet<i32> = [0, 10, 110, 120].iter().map(|&v| sketch[v]).collect();
        assert_eq!(corners.len(), 4);
    }

    #[test]
    fn what_is_far_from_every_true_vertex_is_in_no_region() {
        let flat = sheet(20, 20);
        let at: Vec<[f64; 2]> = flat.positions().iter().map(|p| [p[0], p[1]]).collect();
        let truth = Truth { side: true, points: vec![at[0]], variants: [("front".to_owned(), vec![0])].into() };
        let [sketch, mesh] = of_truth(&truth, 7, (&flat, &at), &flat.clone().into());
        assert!(sketch.iter().all(|&label| label == 0));
        assert_eq!((mesh[0], mesh[1], mesh[20]), (0, 0, -1));
    }
}
