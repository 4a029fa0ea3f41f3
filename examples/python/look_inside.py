"""Matches a sketch to a mesh, reads everything the match was made of, checks it, and draws how the eigenvalues of both
shapes grow.

    python3 look_inside.py http://127.0.0.1:8080 example/quadruped/mesh.obj example/quadruped/sketch.json eigenvalues.svg

Needs Python 3.9 and numpy, and a server that runs.
"""
import io
import json
import sys
import time
import urllib.request

import numpy as np


def call(method, url, body=None, media_type="application/json", accept="application/json"):
    """What a call answers, as bytes."""
    request = urllib.request.Request(url, data=body, method=method, headers={"Accept": accept})
    if body is not None:
        request.add_header("Content-Type", media_type)
    with urllib.request.urlopen(request) as answer:
        return answer.status, answer.read()


def tensors(data):
    """The arrays in a file of safetensors."""
    length = int.from_bytes(data[:8], "little")
    head, body = json.loads(data[8 : 8 + length]), data[8 + length :]
    types = {"F64": "<f8", "F32": "<f4", "I32": "<i4"}
    arrays = {}
    for name, told in head.items():
        if name != "__metadata__":
            begin, end = told["data_offsets"]
            arrays[name] = np.frombuffer(body[begin:end], types[told["dtype"]]).reshape(told["shape"])
    return arrays


def eigenfunctions(server, path, k):
    """The first k eigenfunctions of a shape, a row per vertex; asked for again while they are computed."""
    while True:
        url = f"{server}{path}/spectrum?k={k}"
        status, data = call("GET", url, accept="application/x-npy")
        if status == 200:
            return np.load(io.BytesIO(data))
        time.sleep(0.2)


def svg(curves):
    """Curves over their numbers as SVG."""
    largest, count = max(c.max() for _, c in curves), max(len(c) for _, c in curves)
    lines = []
    for colour, curve in curves:
        points = " ".join(f"{20 + 560 * i / (count - 1):.1f},{380 - 360 * x / largest:.1f}" for i, x in enumerate(curve))
        lines.append(f'<polyline fill="none" stroke="{colour}" stroke-width="2" points="{points}"/>')
    frame = '<rect x="20" y="20" width="560" height="360" fill="none" stroke="#888"/>'
    return f'<svg xmlns="http://www.w3.org/2000/svg" width="600" height="400">{frame}{"".join(lines)}</svg>\n'


def main(server, mesh_file, sketch_file, figure):
    _, mesh = call("POST", f"{server}/v1/meshes", open(mesh_file, "rb").read(), "application/octet-stream")
    _, sketch = call("POST", f"{server}/v1/sketches", open(sketch_file, "rb").read())
    mesh, sketch = json.loads(mesh)["id"], json.loads(sketch)["id"]

    request = {"mesh": mesh, "sketch": sketch, "preset": "thesis", "regulariser": {"type": "none"}}
    _, matched = call("POST", f"{server}/v1/matches", json.dumps(request).encode())
    matched = json.loads(matched)
    while matched["status"] in ("queued", "running"):
        time.sleep(0.2)
        matched = json.loads(call("GET", server + matched["links"]["self"])[1])
    assert matched["status"] == "succeeded", matched

    inside = tensors(call("GET", server + matched["links"]["self"] + "/inside", accept="application/vnd.safetensors")[1])
    a, b, c = inside["a"], inside["b"], inside["c"]
    print(f"{a.shape[1]} corresponding functions; C is {c.shape[0]} x {c.shape[1]}")

    # Without a regulariser C is the least-squares solution of C A = B.
    own = np.linalg.lstsq(a.T, b.T, rcond=None)[0].T
    residual, least = np.linalg.norm(c @ a - b), np.linalg.norm(own @ a - b)
    print(f"|C A - B| is numpy's least times {residual / least:.9f}")

    # Its points are where the images of the sketch's indicators are largest.
    phi = eigenfunctions(server, f"/v1/sketches/{sketch}", c.shape[1])
    psi = np.nan_to_num(eigenfunctions(server, f"/v1/meshes/{mesh}", c.shape[0]), nan=-np.inf)
    images = np.where(np.isinf(psi).any(axis=1)[:, None], -np.inf, np.nan_to_num(psi, neginf=0) @ c @ phi.T)
    largest = images.max(axis=0)
    found = images[inside["points"], np.arange(len(largest))]
    print(f"{np.mean(found >= largest - 1e-6 * abs(largest)):.0%} of the points are the largest of their images")

    with open(figure, "w", encoding="utf-8") as file:
        file.write(svg([("#c03030", inside["sketch_eigenvalues"]), ("#3050c0", inside["mesh_eigenvalues"])]))
    print(f"eigenvalues of sketch (red) and mesh (blue) at area 1: {figure}")


if __name__ == "__main__":
    main(*sys.argv[1:])
