"""Times pyFM on the meshes of the benchmark, one thread, CPU milliseconds: target/bench-data/peer.json."""
import json, os, statistics, sys, time

for variable in ("OMP", "OPENBLAS", "MKL", "NUMEXPR"):
    os.environ[f"{variable}_NUM_THREADS"] = "1"

import numpy as np
import pyFM.mesh
import pyFM.mesh.laplacian as laplacian
import pyFM.signatures as signatures
import pyFM.spectral as spectral
from pyFM.functional import FunctionalMapping
from pyFM.refine.zoomout import zoomout_refine

data = sys.argv[1]
RUNS, REGIONS, found = 5, 7, {}


def timed(name, compute):
    runs = []
    for _ in range(RUNS):
        begun = time.process_time()
        answer = compute()
        runs.append(1e3 * (time.process_time() - begun))
    found[name] = {"median": statistics.median(runs), "min": min(runs), "max": max(runs)}
    print(name, found[name], file=sys.stderr, flush=True)
    return answer


def shape(name, timing):
    mesh = pyFM.mesh.TriMesh(os.path.join(data, name))
    mesh.W = laplacian.cotangent_weights(mesh.vertices, mesh.faces)
    mesh.A = laplacian.dia_area_mat(mesh.vertices, mesh.faces)
    for k in (20, 50, 100):
        solve = lambda: laplacian.laplacian_spectrum(mesh.W, mesh.A, k)
        mesh.eigenvalues, mesh.eigenvectors = timed(f"eig {k}", solve) if timing else solve()
    return mesh


def strips(mesh):
    flat = np.ptp(mesh.vertices[:, 2]) == 0
    along = -mesh.vertices[:, 0] if flat else mesh.vertices[:, 2]
    return np.minimum((along - along.min()) / np.ptp(along) * REGIONS, REGIONS - 1).astype(int)


def descriptors(mesh):
    values = np.hstack([signatures.mesh_HKS(mesh, 100, k=20), signatures.mesh_WKS(mesh, 100, k=20)])
    return values, [mesh.project(values * (strips(mesh) == region)[:, None], k=20) for region in range(REGIONS)]


flat, solid = shape("sketch.off", False), shape(sys.argv[2], True)
on_solid, _ = timed("descriptors", lambda: descriptors(solid))
on_flat, _ = descriptors(flat)
model = FunctionalMapping(solid, flat)
model.descr1 = on_solid / np.sqrt(solid.l2_sqnorm(on_solid))
model.descr2 = on_flat / np.sqrt(flat.l2_sqnorm(on_flat))
timed("fit", lambda: model.fit(K=20, w_descr=1, w_lap=1e-2, w_dcomm=0))
c, psi, phi = model.FM_12, solid.eigenvectors, flat.eigenvectors
timed("indicator", lambda: np.argmax((phi[:, :20] @ c) @ psi[:, :20].T, axis=1))
timed("nearest", lambda: spectral.FM_to_p2p(c, psi, phi, n_jobs=1))
timed("zoomout", lambda: zoomout_refine(c, psi, phi, nit=16, step=5, A2=flat.A, return_p2p=True, n_jobs=1))
with open(os.path.join(data, "peer.json"), "w") as file:
    json.dump(found, file, indent=1)
