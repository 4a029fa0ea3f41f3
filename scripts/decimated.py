#!/usr/bin/env python3
"""Matches silhouettes on meshes of few vertices, as games have them, and says where on the mesh of before the answers lie.

    python3 scripts/decimated.py CASES OUT [--vertices 300 1000] [--server http://127.0.0.1:8080]

Every folder of CASES holds mesh.off and sketch.json. The mesh is decimated by quadrics; the place of a correspondence, by its
triangle and its weights, is told as the nearest vertex of the whole mesh, in OUT/VERTICES/<case>/result.json, for whom knows the
truth there. Needs numpy, scipy, fast-simplification.
"""
import argparse
import json
import os

import fast_simplification
import numpy as np
from scipy.spatial import cKDTree

from broken_meshes import obj, read_off
from landmarks import called, posted


def decimated(vertices, triangles, wanted):
    # A closed surface has about two triangles for each vertex.
    return fast_simplification.simplify(vertices, triangles, target_count=2 * wanted)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases")
    parser.add_argument("out")
    parser.add_argument("--vertices", type=int, nargs="+", default=[300, 1000])
    parser.add_argument("--server", default="http://127.0.0.1:8080")
    options = parser.parse_args()
    for name in sorted(os.listdir(options.cases)):
        folder = os.path.join(options.cases, name)
        if not os.path.exists(os.path.join(folder, "mesh.off")):
            continue
        vertices, triangles = read_off(os.path.join(folder, "mesh.off"))
        drawing = json.load(open(os.path.join(folder, "sketch.json")))
        sketch = posted(options.server, "/v1/sketches", {"outline": drawing["outline"], "holes": drawing.get("holes", [])})
        for wanted in options.vertices:
            few, corners = decimated(vertices, triangles, wanted)
            mesh = called(options.server, "POST", "/v1/meshes?format=obj", obj(few, corners), "application/octet-stream")
            match = posted(options.server, "/v1/matches", {"mesh": mesh["id"], "sketch": sketch["id"]}, prefer="wait=120")
            result = called(options.server, "GET", f"/v1/matches/{match['id']}/result")
            answers = result["correspondences"]
            places = np.array([np.array(a["barycentric"]) @ few[a["triangle"]] for a in answers])
            _, nearest = cKDTree(vertices).query(places)
            told = [{"point": a["point"], "mesh_vertex": int(v)} for a, v in zip(answers, nearest)]
            into = os.path.join(options.out, str(wanted), name)
            os.makedirs(into, exist_ok=True)
            with open(os.path.join(into, "result.json"), "w") as file:
                json.dump({"correspondences": told}, file)
            print(f"{name:60} {len(vertices):6} to {len(few):5} vertices, rated {result['rating']}", flush=True)


if __name__ == "__main__":
    main()
