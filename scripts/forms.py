#!/usr/bin/env python3
"""Matches sketches as JSON outlines, as SVG and as PNG, and writes the answers to all three in the outline's coordinates.

    python3 scripts/forms.py --server http://127.0.0.1:8080 --out DIR CASE...

A CASE is a folder with mesh.off, sketch.json (outline and holes, y up, in pixels of the picture) and sketch.png, the same
figure. The SVG is made of the outline. DIR/<form>/<case>.json is a result that a scoring script can read, so that the three
forms' errors can be held against each other: what a sketch is sent as should not matter.
"""
import argparse
import json
import struct
import urllib.request
from pathlib import Path


def call(server, method, path, body=None, kind="application/json"):
    request = urllib.request.Request(
        server + path, data=body, method=method, headers={"Content-Type": kind, "Prefer": "wait=60"}
    )
    with urllib.request.urlopen(request, timeout=600) as answer:
        return json.load(answer)


def svg_of(drawing, width, height):
    """The outline and its holes as one path, y down."""
    rings = [drawing["outline"], *drawing.get("holes", [])]
    path = "".join("M" + "L".join(f"{x} {height - y}" for x, y in ring) + "Z" for ring in rings)
    return f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}"><path fill-rule="evenodd" d="{path}"/></svg>'


def matched(server, mesh, body, kind):
    sketch = call(server, "POST", "/v1/sketches", body, kind)["id"]
    job = call(server, "POST", "/v1/matches", json.dumps({"mesh": mesh, "sketch": sketch}).encode())
    while job["status"] in ("queued", "running"):
        job = call(server, "GET", f"/v1/matches/{job['id']}")
    if job["status"] != "succeeded":
        raise SystemExit(f"the match {job['status']}: {job.get('error')}")
    return call(server, "GET", f"/v1/matches/{job['id']}/result")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--server", default="http://127.0.0.1:8080")
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("cases", nargs="+", type=Path)
    options = parser.parse_args()
    for case in options.cases:
        outline, picture = (case / "sketch.json").read_bytes(), (case / "sketch.png").read_bytes()
        width, height = struct.unpack(">II", picture[16:24])
        svg = svg_of(json.loads(outline), width, height).encode()
        mesh = call(
            options.server, "POST", "/v1/meshes?format=off", (case / "mesh.off").read_bytes(), "application/octet-stream"
        )["id"]
        for form, body, kind in [
            ("json", outline, "application/json"),
            ("svg", svg, "image/svg+xml"),
            ("png", picture, "image/png"),
        ]:
            result = matched(options.server, mesh, body, kind)
            if form != "json":
                for correspondence in result["correspondences"]:
                    correspondence["point"][1] = height - correspondence["point"][1]
            path = options.out / form / f"{case.name}.json"
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(json.dumps(result), encoding="utf-8")
            print(f"{case.name} {form}: {result['rating']} {result['confidence']:.3f}", flush=True)


if __name__ == "__main__":
    main()
