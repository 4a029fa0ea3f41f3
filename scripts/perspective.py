#!/usr/bin/env python3
"""What a camera nearby costs: silhouettes of meshes seen broadside and by 30° beside that, without perspective and with it.

    python3 -m venv venv && venv/bin/pip install numpy pillow
    venv/bin/python scripts/perspective.py MESH [MESH ...] [--server http://127.0.0.1:8080] [--near 2.5]

A MESH is an OBJ or an OFF of a body that stands along +y, or along +z with --z-up, and reaches farthest along another axis. It is
looked at from far and from a distance of --near times its size. Errors are those of `POST /v1/matches/{id}/evaluations`: the truth of
a pixel is the vertex nearest to what the camera sees there first, or last, or the twin of either across the middle of the body.
"""
import argparse
import io
import math

import numpy as np
from PIL import Image

from broken_meshes import read_off
from landmarks import called, posted

SIZE = 512
MARGIN = 30
POINTS = 200
FAR = 1e4


def read(path):
    """Vertices and triangles of an OBJ or an OFF, polygons of an OBJ as fans."""
    if path.endswith(".off"):
        return read_off(path)
    words = [line.split() for line in open(path) if line.strip()]
    vertices = [row[1:4] for row in words if row[0] == "v"]
    polygons = [[int(v.split("/")[0]) - 1 for v in row[1:]] for row in words if row[0] == "f"]
    triangles = [[p[0], p[i], p[i + 1]] for p in polygons for i in range(1, len(p) - 1)]
    return np.array(vertices, float), np.array(triangles)


def seen(vertices, triangles, right, up, distance):
    """What a camera sees: the mask, and for every pixel the vertex nearest to what is there first and last."""
    middle = (vertices.min(0) + vertices.max(0)) / 2
    size = np.linalg.norm(vertices.max(0) - vertices.min(0))
    toward = np.cross(right, up)
    at = vertices - middle
    depth = distance * size - at @ toward
    flat = np.stack([at @ right, -(at @ up)], 1) / depth[:, None]
    low = flat.min(0)
    scale = (SIZE - 2 * MARGIN) / (flat.max(0) - low).max()
    pixels = MARGIN + (flat - low) * scale
    first, last = np.full((SIZE, SIZE), np.inf), np.full((SIZE, SIZE), -np.inf)
    vertex = np.full((2, SIZE, SIZE), -1)
    for corners in triangles:
        a, b, c = pixels[corners]
        doubled = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
        left, top = np.floor(pixels[corners].min(0)).astype(int)
        right_, bottom = np.ceil(pixels[corners].max(0)).astype(int) + 1
        if abs(doubled) < 1e-12:
            continue
        y, x = np.mgrid[top:bottom, left:right_]
        u = ((b[0] - x) * (c[1] - y) - (b[1] - y) * (c[0] - x)) / doubled
        v = ((c[0] - x) * (a[1] - y) - (c[1] - y) * (a[0] - x)) / doubled
        weights = np.stack([u, v, 1 - u - v])
        inside = (weights >= -1e-9).all(0)
        z = np.tensordot(depth[corners], weights, 1)
        nearest = corners[weights.argmax(0)]
        part = (slice(top, bottom), slice(left, right_))
        for layer, (buffer, better) in enumerate([(first, np.less), (last, np.greater)]):
            new = inside & better(z, buffer[part])
            buffer[part][new] = z[new]
            vertex[layer][part][new] = nearest[new]
    return vertex


def twins(vertices, up):
    """For every vertex the nearest to its mirror image across the vertical plane that fits best."""
    best = (np.inf, None)
    for axis in [axis for axis in range(3) if up[axis] == 0]:
        mirrored = vertices.copy()
        mirrored[:, axis] = vertices[:, axis].min() + vertices[:, axis].max() - vertices[:, axis]
        away = [((vertices - place) ** 2).sum(1) for place in mirrored]
        nearest = np.array([distances.argmin() for distances in away])
        best = min(best, (sum(distances.min() for distances in away), nearest), key=lambda found: found[0])
    return best[1]


def error(server, mesh, vertex, twin):
    mask = vertex[0] >= 0
    picture = io.BytesIO()
    Image.fromarray(np.where(mask, 0, 255).astype(np.uint8)).save(picture, "PNG")
    sketch = called(server, "POST", "/v1/sketches", picture.getvalue(), "image/png")["id"]
    ys, xs = np.nonzero(mask)
    chosen = np.linspace(0, len(xs) - 1, POINTS).astype(int)
    points = [[float(x) + 0.5, float(y) + 0.5] for x, y in zip(xs[chosen], ys[chosen])]
    variants = {name: [int(v) for v in layer[ys[chosen], xs[chosen]]] for name, layer in zip(["front", "back"], vertex)}
    variants |= {f"{name}_mirrored": [int(twin[v]) for v in seen] for name, seen in variants.items()}
    match = posted(server, "/v1/matches", {"mesh": mesh, "sketch": sketch}, prefer="wait=120")
    truth = {"pairs": {"side": True, "points": points, "variants": variants}}
    judged = posted(server, f"/v1/matches/{match['id']}/evaluations", truth)
    return judged["pairs"]["coherent"]["mean"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("meshes", nargs="+")
    parser.add_argument("--server", default="http://127.0.0.1:8080")
    parser.add_argument("--near", type=float, default=2.5)
    parser.add_argument("--z-up", action="store_true")
    options = parser.parse_args()
    up = np.array([0, 0, 1.0]) if options.z_up else np.array([0, 1.0, 0])
    found = []
    for path in options.meshes:
        vertices, triangles = read(path)
        kind = path.rsplit(".", 1)[1]
        mesh = called(options.server, "POST", f"/v1/meshes?format={kind}", open(path, "rb").read(), "application/octet-stream")["id"]
        extent = (vertices.max(0) - vertices.min(0)) * (1 - up)
        broad, twin = np.eye(3)[extent.argmax()], twins(vertices, up)
        for degrees in [-30, 0, 30]:
            turn = math.radians(degrees)
            right = math.cos(turn) * broad + math.sin(turn) * np.cross(up, broad)
            errors = []
            for distance in [FAR, options.near]:
                errors.append(error(options.server, mesh, seen(vertices, triangles, right, up, distance), twin))
            found.append(errors)
            print(f"{path.split('/')[-2]}/{path.split('/')[-1]} from {degrees:3}°: {errors[0]:.3f} from far, {errors[1]:.3f} from nearby", flush=True)
    far, near = np.mean(found, 0)
    print(f"{len(found)} views: {far:.3f} from far, {near:.3f} from nearby")


if __name__ == "__main__":
    main()
