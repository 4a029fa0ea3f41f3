#!/usr/bin/env python3
"""The terms that are added to the energy against pyFM: its own operators and its own minimiser on the same functions.

    python3 -m venv venv && venv/bin/pip install pyfmaps
    venv/bin/python scripts/peer_terms.py MESH SKETCH [--server http://127.0.0.1:8080] [--weight 10]

MESH is an OBJ, SKETCH an outline in JSON, as `sketchmatch example` writes them. The match is the thesis preset with regions alone and
no regulariser, so that the minimiser is that of data and term. Printed are ‖C − C'‖ / ‖C'‖, C' being pyFM's, and how much lower
pyFM's energy is at ours; both with each term and without any.
"""
import argparse
import json
import struct
import time
import urllib.request

import numpy as np
import pyFM.optimize.base_functions as energies
from pyFM.mesh import TriMesh
from scipy.optimize import minimize

K = 20


def called(server, method, path, body=None, kind="application/json", accept="application/json", **headers):
    headers = {"content-type": kind, "accept": accept, **headers}
    request = urllib.request.Request(server + path, data=body, method=method, headers=headers)
    with urllib.request.urlopen(request) as answer:
        pending, content = answer.status == 202 and method == "GET", answer.read()
    if pending:
        time.sleep(0.2)
        return called(server, method, path, body, kind, accept)
    return content


def arrays(file):
    """The arrays of a safetensors file by name."""
    length = struct.unpack("<Q", file[:8])[0]
    kinds = {"F64": "<f8", "I32": "<i4"}
    found = {}
    for name, about in json.loads(file[8 : 8 + length]).items():
        begin, end = (8 + length + offset for offset in about["data_offsets"])
        found[name] = np.frombuffer(file[begin:end], kinds[about["dtype"]]).reshape(about["shape"])
    return found


class Shape:
    """A shape at area 1 with its basis, and operators in it as pyFM makes them."""

    def __init__(self, server, path):
        shape = json.loads(called(server, "GET", f"{path}/mesh"))
        spectrum = f"{path}/spectrum?k={K}"
        tensors = arrays(called(server, "GET", spectrum, accept="application/vnd.safetensors"))
        self.mass = tensors["mass"] / tensors["mass"].sum()
        root = np.sqrt(tensors["mass"].sum())
        self.basis = tensors["eigenfunctions"] * root
        places = np.array(shape["vertices"], float)
        places = np.pad(places, ((0, 0), (0, 3 - places.shape[1])))
        self.mesh = TriMesh(places / root, np.array(shape["triangles"]))

    def reduced(self, operator):
        return self.basis.T @ operator

    def multiplication(self, f):
        return self.reduced((self.mass * f)[:, None] * self.basis)

    def turning(self, f):
        gradient = self.mesh.gradient(f)
        operator = self.mesh.orientation_op(gradient)
        found = self.reduced(self.mesh.vertex_areas[:, None] * (operator @ self.basis))
        return found / np.linalg.norm(found)


def indicators(labels, numbers, mass):
    """The indicators of regions, each in units of its root mean square."""
    found = [(labels == number).astype(float) for number in numbers]
    return [f / np.sqrt((mass * f * f).sum()) for f in found]


def minimised(a, b, differences, operators):
    """C of pyFM's energy 1/2 ‖C a − b‖² + 1/2 Σ differences ⊙ C² + 1/2 Σ ‖C x − y C‖², by L-BFGS as pyFM finds it."""
    shape = (b.shape[0], a.shape[0])

    def energy(flat):
        c = flat.reshape(shape)
        parts = [energies.descr_preservation_and_grad(c, a, b), energies.LB_commutation_and_grad(c, differences)]
        if len(operators) > 0:
            parts.append(energies.oplist_commutation_and_grad(c, operators))
        return sum(part[0] for part in parts), sum(part[1] for part in parts).ravel()

    begin = np.linalg.lstsq(a.T, b.T, rcond=None)[0].T.ravel()
    options = {"maxiter": 100_000, "maxfun": 200_000, "ftol": 1e-16, "gtol": 1e-11, "maxcor": 50}
    found = minimize(energy, begin, jac=True, method="L-BFGS-B", options=options)
    return found.x.reshape(shape), lambda c: energy(c.ravel())[0]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("mesh")
    parser.add_argument("sketch")
    parser.add_argument("--server", default="http://127.0.0.1:8080")
    parser.add_argument("--weight", type=float, default=10.0)
    options = parser.parse_args()
    server, weight = options.server, options.weight
    uploaded = lambda path, name, kind: json.loads(called(server, "POST", path, open(name, "rb").read(), kind))["id"]
    mesh = uploaded("/v1/meshes?format=obj", options.mesh, "application/octet-stream")
    sketch = uploaded("/v1/sketches", options.sketch, "application/json")
    shapes = [Shape(server, f"/v1/sketches/{sketch}"), Shape(server, f"/v1/meshes/{mesh}")]
    for term in [None, "laplacian", "descriptors", "orientation"]:
        request = {
            "mesh": mesh, "sketch": sketch, "preset": "thesis", "regulariser": {"type": "none"},
            "descriptors": {"hks": {"count": 0}, "wks": {"count": 0}},
            "terms": [{"type": term, "weight": weight}] if term else [],
        }
        match = json.loads(called(server, "POST", "/v1/matches", json.dumps(request).encode(), prefer="wait=60"))
        result = json.loads(called(server, "GET", f"/v1/matches/{match['id']}/result"))
        inside = arrays(called(server, "GET", f"/v1/matches/{match['id']}/inside", accept="*/*"))
        pairs = [(pair["sketch"], pair["mesh"]) for pair in result["intermediate"]["regions"]["pairs"]]
        functions = [
            indicators(inside[f"{side}_regions"], [pair[i] for pair in pairs], shape.mass)
            for i, (side, shape) in enumerate(zip(["sketch", "mesh"], shapes))
        ]
        values = [inside["sketch_eigenvalues"], inside["mesh_eigenvalues"] * result["intermediate"]["spectral_scale"]]
        values = [each / max(part.max() for part in values) for each in values]
        differences, operators = np.zeros(inside["c"].shape), []
        if term == "laplacian":
            differences = weight * (values[0][None, :] - values[1][:, None]) ** 2
        elif term:
            made = Shape.multiplication if term == "descriptors" else Shape.turning
            share = np.sqrt(weight / len(pairs))
            operators = [np.array([share * made(shape, f) for f in of_shape]) for shape, of_shape in zip(shapes, functions)]
        c, energy = minimised(inside["a"], inside["b"], differences, operators)
        away = np.linalg.norm(inside["c"] - c) / np.linalg.norm(c)
        ours, theirs = energy(inside["c"]), energy(c)
        print(f"{term or 'none':12} C apart {away:.1e}; energy {ours:.9f}, pyFM's {theirs:.9f}")


if __name__ == "__main__":
    main()
