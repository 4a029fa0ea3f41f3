//! The Laplacian of a mesh and its eigenpairs.

mod intrinsic;
pub mod laplacian;
pub mod rebuilt;

use faer::Mat;
use serde::{Deserialize, Serialize};
use sprs::CsMat;
use utoipa::ToSchema;

use crate::mesh::{TriangleMesh, connectivity};
use crate::numerics::block_lanczos::{self, EigenError, Eigenpairs};
use crate::numerics::{Cancelled, Watch};
use laplacian::Lumping;

/// Raised with every change that alters a spectrum: part of the key under which spectra are cached.
pub const SOLVER_VERSION: u32 = 4;

/// The numbers of eigenpairs that are computed, whatever fewer are asked for.
///
/// Within a repeated eigenvalue the eigenfunctions depend on how many pairs are sought, so that a match would depend on
/// what happens to be cached if every number were.
pub const RUNGS: [usize; 6] = [20, 60, 100, 150, 250, 500];

/// The number of eigenpairs that are computed where k are asked for: the next rung, or k above the last.
pub fn rung(k: usize) -> usize {
    RUNGS.into_iter().find(|&rung| rung >= k).unwrap_or(k)
}

/// What an eigenfunction does at the boundary of the mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize, ToSchema)]
#[serde(rename_all = "snake_case")]
pub enum Boundary {
    /// Free: no flow across it.
    Neumann,
    /// Fixed at zero.
    Dirichlet,
}

/// Why a mesh has no such spectrum.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SpectralError {
    #[error("{k} eigenfunctions were asked for, but the mesh has only {most} free vertices")]
    TooMany { k: usize, most: usize },
    #[error("a vertex has no area of its own: its triangles are too thin")]
    NoMass,
    #[error(transparent)]
    Eigen(#[from] EigenError),
}

impl From<Cancelled> for SpectralError {
    fn from(cancelled: Cancelled) -> SpectralError {
        SpectralError::Eigen(cancelled.into())
    }
}

/// The first k eigenpairs of S φ = λ A φ on a connected mesh of n vertices, S the cotangent stiffness and A the lumped
/// mass, in ascending order of λ.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum {
    /// k values in units of 1/length², ascending; the first is 0 where no vertex is fixed.
    pub eigenvalues: Vec<f64>,
    /// n × k, Φᵀ A Φ = I; under Dirichlet conditions the rows of boundary vertices are zero. The sign of a column makes
    /// its entry of largest magnitude positive (the first of equals).
    pub eigenfunctions: Mat<f64>,
    /// Diagonal of A: n areas that sum to the mesh's.
    pub mass: Vec<f64>,
}

impl Spectrum {
    /// Number of eigenpairs, k.
    pub fn len(&self) -> usize {
        self.eigenvalues.len()
    }

    pub fn is_empty(&self) -> bool {
        self.eigenvalues.is_empty()
    }

    /// Number of vertices, n.
    pub fn vertices(&self) -> usize {
        self.mass.len()
    }

    /// The area of the mesh, in squared units of the file.
    pub fn area(&self) -> f64 {
        self.mass.iter().sum()
    }

    /// The spectrum of the same mesh scaled to area 1, its first k pairs: λ · area, φ · √area, mass / area.
    pub fn at_unit_area(&self, k: usize) -> Spectrum {
        let area = self.area();
        Spectrum {
            eigenvalues: self.eigenvalues.iter().take(k).map(|l| l * area).collect(),
            eigenfunctions: self.eigenfunctions.subcols(0, k.min(self.len())) * faer::Scale(area.sqrt()),
            mass: self.mass.iter().map(|m| m / area).collect(),
        }
    }
}

/// The first [`rung`]`(k)` eigenpairs of a connected mesh whose every vertex has a triangle, or all there are, with mixed
/// lumping.
///
/// # Errors
/// [`SpectralError`]: k is larger than the number of free vertices, a triangle is so thin that the operator is singular
/// in floating point, or the watcher stopped it.
pub fn spectrum(
    mesh: &TriangleMesh,
    k: usize,
    boundary: Boundary,
    watch: &dyn Watch,
) -> Result<Spectrum, SpectralError> {
    let most = free_vertices(mesh, boundary).len();
    if k > most {
        return Err(SpectralError::TooMany { k, most });
    }
    spectrum_with(mesh, Lumping::Mixed, rung(k).min(most), boundary, watch)
}

/// Exactly the first k eigenpairs, with the lumping as told.
///
/// # Errors
/// As [`spectrum`].
pub fn spectrum_with(
    mesh: &TriangleMesh,
    lumping: Lumping,
    k: usize,
    boundary: Boundary,
    watch: &dyn Watch,
) -> Result<Spectrum, SpectralError> {
    // Each step takes some tens of milliseconds at 100,000 vertices.
    let thinned = intrinsic::without_thin(mesh, watch).map_err(EigenError::from)?;
    watch.proceed(0.0)?;
    let (stiffness, mass) = match thinned {
        Some(triangles) => triangles.operator(mesh.positions().len(), lumping),
        None => {
            let stiffness = laplacian::stiffness(mesh);
            watch.proceed(0.0)?;
            (stiffness, laplacian::mass(mesh, lumping))
        }
    };
    watch.proceed(0.0)?;
    if !mass.iter().all(|&m| m > 0.0 && m.is_finite()) || !stiffness.data().iter().all(|s| s.is_finite()) {
        return Err(SpectralError::NoMass);
    }
    let area: f64 = mass.iter().sum();
    let free = free_vertices(mesh, boundary);
    if k > free.len() {
        return Err(SpectralError::TooMany { k, most: free.len() });
    }
    // The solver's shift is meant for unit area; a length scaled by s divides λ by s² and leaves S as it is.
    let unit_mass: Vec<f64> = free.iter().map(|&v| mass[v] / area).collect();
    let stiffness = restricted(&stiffness, &free);
    watch.proceed(0.0)?;
    let pairs = block_lanczos::smallest(&stiffness, &unit_mass, k, watch)?;
    let mut spectrum = Spectrum {
        eigenvalues: pairs.values.iter().map(|l| l.max(0.0) / area).collect(),
        eigenfunctions: scattered(&pairs, &free, mass.len(), 1.0 / area.sqrt()),
        mass,
    };
    if k > 0 && free.len() == spectrum.mass.len() {
        // Known exactly: where nothing is fixed, the constants are the kernel of S on a connected mesh.
        spectrum.eigenvalues[0] = 0.0;
        spectrum.eigenfunctions.col_mut(0).fill(1.0 / area.sqrt());
    }
    Ok(spectrum)
}

/// The vertices whose value is not fixed, ascending.
fn free_vertices(mesh: &TriangleMesh, boundary: Boundary) -> Vec<usize> {
    let n = mesh.positions().len();
    match boundary {
        Boundary::Neumann => (0..n).collect(),
        Boundary::Dirichlet => {
            let fixed = connectivity::boundary_vertices(mesh);
            (0..n).filter(|&v| !fixed[v]).collect()
        }
    }
}

/// The rows and columns of the free vertices.
fn restricted(matrix: &CsMat<f64>, free: &[usize]) -> CsMat<f64> {
    if free.len() == matrix.rows() {
        return matrix.clone();
    }
    let mut place = vec![usize::MAX; matrix.rows()];
    for (new, &old) in free.iter().enumerate() {
        place[old] = new;
    }
    let (mut indptr, mut indices, mut data) = (vec![0], Vec::new(), Vec::new());
    for row in free.iter().filter_map(|&v| matrix.outer_view(v)) {
        for (column, &value) in row.iter().filter(|(column, _)| place[*column] != usize::MAX) {
            indices.push(place[column]);
            data.push(value);
        }
        indptr.push(indices.len());
    }
    CsMat::new((free.len(), free.len()), indptr, indices, data)
}

/// The eigenvectors on all n vertices, times `factor`, signs fixed.
fn scattered(pairs: &Eigenpairs, free: &[usize], n: usize, factor: f64) -> Mat<f64> {
    let mut functions = Mat::zeros(n, pairs.vectors.ncols());
    for j in 0..pairs.vectors.ncols() {
        let column = pairs.vectors.col_as_slice(j);
        let largest = column.iter().fold(0.0f64, |best, &x| if x.abs() > best.abs() { x } else { best });
        for (&vertex, value) in free.iter().zip(column) {
            functions[(vertex, j)] = factor * largest.signum() * value;
        }
    }
    functions
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::numerics::Unwatched;

    /// A w × h rectangle in a grid of nx × ny cells with alternating diagonals.
    fn rectangle(w: f64, h: f64, nx: usize, ny: usize) -> TriangleMesh {
        let at = |i: usize, j: usize| (j * (nx + 1) + i) as u32;
        let positions = (0..=ny)
            .flat_map(|j| (0..=nx).map(move |i| [w * i as f64 / nx as f64, h * j as f64 / ny as f64, 0.0]))
            .collect();
        let mut triangles = Vec::new();
        for (i, j) in (0..ny).flat_map(|j| (0..nx).map(move |i| (i, j))) {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            triangles.extend(if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] });
        }
        TriangleMesh::new(positions, triangles).unwrap()
    }

    /// The octahedron with every triangle split into `frequency`² and its vertices brought to the unit sphere.
    fn sphere(frequency: usize) -> TriangleMesh {
        let mut ids = std::collections::BTreeMap::new();
        let mut positions = Vec::new();
        let mut triangles = Vec::new();
        let f = frequency as i64;
        let mut vertex = |lattice: [i64; 3]| {
            *ids.entry(lattice).or_insert_with(|| {
                let p = lattice.map(|x| x as f64);
                let r = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt();
                positions.push(p.map(|x| x / r));
                positions.len() as u32 - 1
            })
        };
        for signs in 0..8 {
            let sign = [0, 1, 2].map(|axis| if signs >> axis & 1 == 1 { -1 } else { 1 });
            let mirrored = sign.iter().product::<i64>() < 0;
            let mut add = |corners: [[i64; 2]; 3]| {
                let [a, b, c] = corners.map(|[x, y]| vertex([sign[0] * x, sign[1] * y, sign[2] * (f - x - y)]));
                triangles.push(if mirrored { [a, c, b] } else { [a, b, c] });
            };
            for x in 0..f {
                for y in 0..f - x {
                    add([[x, y], [x + 1, y], [x, y + 1]]);
                    if x + y < f - 1 {
                        add([[x + 1, y], [x + 1, y + 1], [x, y + 1]]);
                    }
                }
            }
        }
        TriangleMesh::new(positions, triangles).unwrap()
    }

    fn assert_eigenpairs(mesh: &TriangleMesh, spectrum: &Spectrum) {
        let stiffness = laplacian::stiffness(mesh);
        let (phi, mass, area) = (&spectrum.eigenfunctions, &spectrum.mass, spectrum.area());
        for i in 0..spectrum.len() {
            for j in 0..=i {
                let inner: f64 = (0..mass.len()).map(|v| mass[v] * phi[(v, i)] * phi[(v, j)]).sum();
                let expected = if i == j { 1.0 } else { 0.0 };
                assert!((inner - expected).abs() < 1e-8, "⟨{i}, {j}⟩ = {inner}");
            }
        }
        let fixed = |v: usize| (0..spectrum.len()).all(|j| phi[(v, j)] == 0.0);
        for j in 0..spectrum.len() {
            let mut squared = 0.0;
            for (v, row) in stiffness.outer_iterator().enumerate().filter(|(v, _)| !fixed(*v)) {
                let image: f64 = row.iter().map(|(u, s)| s * phi[(u, j)]).sum();
                let residual = image - spectrum.eigenvalues[j] * mass[v] * phi[(v, j)];
                squared += residual * residual / mass[v];
            }
            // ‖A^−½ (S φ − λ A φ)‖ in units of 1/area, relative to λ above 1.
            let residual = squared.sqrt() * area;
            let scale = (spectrum.eigenvalues[j] * area).max(1.0);
            assert!(residual < 1e-8 * scale, "pair {j}: residual {residual:e}, scale {scale}");
        }
    }

    #[test]
    fn the_next_rung_is_computed() {
        assert_eq!([1, 20, 21, 500, 501].map(rung), [20, 20, 60, 500, 501]);
    }

    #[test]
    fn stiffness_is_symmetric_with_zero_row_sums_and_mass_sums_to_the_area() {
        for mesh in [rectangle(2.0, 1.0, 9, 7), sphere(6)] {
            let stiffness = laplacian::stiffness(&mesh);
            for (i, row) in stiffness.outer_iterator().enumerate() {
                assert!(row.iter().map(|(_, s)| s).sum::<f64>().abs() < 1e-12);
                for (j, s) in row.iter() {
                    assert_eq!(stiffness.get(j, i), Some(s));
                }
            }
            for lumping in [Lumping::Mixed, Lumping::Barycentric] {
                let mass = laplacian::mass(&mesh, lumping);
                assert!(mass.iter().all(|&m| m > 0.0));
                assert!((mass.iter().sum::<f64>() - mesh.area()).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn an_obtuse_triangle_has_positive_mass() {
        let mesh = TriangleMesh::new(vec![[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [1.0, 0.5, 0.0]], vec![[0, 1, 2]]).unwrap();
        assert_eq!(laplacian::mass(&mesh, Lumping::Mixed), vec![0.25, 0.25, 0.5]);
    }

    #[test]
    fn rectangle_spectra_converge_to_the_known_ones() {
        let (w, h) = (2.0, 1.3);
        for (boundary, first) in [(Boundary::Neumann, 0), (Boundary::Dirichlet, 1)] {
            let mut known: Vec<f64> = (first..12)
                .flat_map(|i| (first..12).map(move |j| (i as f64 / w).powi(2) + (j as f64 / h).powi(2)))
                .map(|x| PI * PI * x)
                .collect();
            known.sort_by(f64::total_cmp);
            let errors = [30, 60].map(|cells| {
                let mesh = rectangle(w, h, cells, cells);
                let spectrum = spectrum(&mesh, 10, boundary, &Unwatched).unwrap();
                assert_eigenpairs(&mesh, &spectrum);
                let worst = |(l, k): (&f64, &f64)| (l - k).abs() / k.max(1.0);
                spectrum.eigenvalues.iter().zip(&known).map(worst).fold(0.0, f64::max)
            });
            // Second order in the edge length: about a quarter of the error at half of it.
            assert!(errors[1] < 0.02 && errors[1] < 0.3 * errors[0], "{boundary:?}: {errors:?}");
        }
    }

    #[test]
    fn every_repeated_eigenvalue_of_the_sphere_is_found() {
        let mesh = sphere(24);
        let spectrum = spectrum(&mesh, 49, Boundary::Neumann, &Unwatched).unwrap();
        assert_eigenpairs(&mesh, &spectrum);
        // l (l + 1), each 2l + 1 times.
        let known = (0..7).flat_map(|l| std::iter::repeat_n((l * (l + 1)) as f64, 2 * l + 1));
        for (j, (value, known)) in spectrum.eigenvalues.iter().zip(known).enumerate() {
            assert!((value - known).abs() <= 0.03 * known, "λ_{j} = {value} for {known}");
        }
    }

    #[test]
    fn sparse_and_dense_agree() {
        let mesh = rectangle(1.7, 1.0, 24, 18);
        let (stiffness, mass) = (laplacian::stiffness(&mesh), laplacian::mass(&mesh, Lumping::Mixed));
        let sparse = block_lanczos::smallest(&stiffness, &mass, 30, &Unwatched).unwrap();
        let dense = block_lanczos::smallest(&stiffness, &mass, 160, &Unwatched).unwrap();
        for j in 1..30 {
            assert!((sparse.values[j] / dense.values[j] - 1.0).abs() < 1e-10);
        }
    }

    #[test]
    fn sparse_and_dense_agree_on_the_repeated_eigenvalues_of_a_sphere() {
        let mesh = sphere(15);
        let (stiffness, mass) = (laplacian::stiffness(&mesh), laplacian::mass(&mesh, Lumping::Barycentric));
        let dense = block_lanczos::smallest(&stiffness, &mass, 300, &Unwatched).unwrap();
        for k in (17..=60).step_by(3) {
            let sparse = block_lanczos::smallest(&stiffness, &mass, k, &Unwatched).unwrap();
            for j in 1..k {
                assert!((sparse.values[j] / dense.values[j] - 1.0).abs() < 1e-9, "λ_{j} of {k}");
            }
        }
    }

    #[test]
    fn scale_divides_eigenvalues_by_its_square() {
        let mesh = rectangle(1.7, 1.0, 24, 18);
        let positions = mesh.positions().iter().map(|p| p.map(|x| 1000.0 * x)).collect();
        let larger = TriangleMesh::new(positions, mesh.triangles().to_vec()).unwrap();
        let [small, large] = [&mesh, &larger].map(|m| spectrum(m, 10, Boundary::Neumann, &Unwatched).unwrap());
        for j in 1..10 {
            assert!((large.eigenvalues[j] * 1e6 / small.eigenvalues[j] - 1.0).abs() < 1e-9);
        }
    }

    #[test]
    fn too_many_pairs_are_refused_and_a_watcher_can_stop() {
        let mesh = rectangle(1.0, 1.0, 3, 3);
        assert_eq!(spectrum(&mesh, 5, Boundary::Dirichlet, &Unwatched), Err(SpectralError::TooMany { k: 5, most: 4 }));
        struct Impatient;
        impl Watch for Impatient {
            fn proceed(&self, _fraction: f64) -> Result<(), crate::numerics::Cancelled> {
                Err(crate::numerics::Cancelled)
            }
        }
        let mesh = rectangle(1.0, 1.0, 30, 30);
        let stopped = spectrum(&mesh, 10, Boundary::Neumann, &Impatient);
        assert!(matches!(stopped, Err(SpectralError::Eigen(EigenError::Cancelled(_)))));
    }
}
