#!/usr/bin/env python3
"""How much an answer changes with a drawing that changes little: silhouettes whose truth is known, as they are, drawn by a hand
that trembles, turned and mirrored.

    python3 scripts/steadiness.py CASES [CASES ...] [--server http://127.0.0.1:8080]

Every folder of CASES holds mesh.off, sketch.json and truth.json. Errors are those of `POST /v1/matches/{id}/evaluations`, of the
reading that fits best as a whole. The same sketches as SVG and PNG are forms.py's. Standard library only.
"""
import argparse
import json
import math
import os
import random
import urllib.error

from landmarks import called, posted

# The hand's tremble: its largest excursion as a share of the figure's longer side, and its waves along the outline.
TREMBLE = 0.01
WAVES = range(10, 40)
TURN = math.radians(30)


def size(rings):
    return max(max(p[axis] for ring in rings for p in ring) - min(p[axis] for ring in rings for p in ring) for axis in (0, 1))


def trembled(rings):
    """Every ring displaced by smooth noise; the same every time."""
    noise = random.Random(1)
    most = TREMBLE * size(rings)
    found = []
    for ring in rings:
        waves = [[(noise.gauss(0, 1), noise.uniform(0, 2 * math.pi)) for _ in WAVES] for _ in (0, 1)]
        lengths = [0.0]
        for a, b in zip(ring, ring[1:] + ring[:1]):
            lengths.append(lengths[-1] + math.dist(a, b))
        shifts = [
            [sum(a * math.sin(2 * math.pi * k * s / lengths[-1] + phase) for k, (a, phase) in zip(WAVES, wave)) for wave in waves]
            for s in lengths[:-1]
        ]
        largest = max(math.hypot(*shift) for shift in shifts)
        found.append([[p[axis] + most * shift[axis] / largest for axis in (0, 1)] for p, shift in zip(ring, shifts)])
    return found


def turned(point):
    (x, y), cos, sin = point, math.cos(TURN), math.sin(TURN)
    return [cos * x - sin * y, sin * x + cos * y]


def mirrored(point):
    return [-point[0], point[1]]


CHANGES = {
    "untouched": (lambda rings: rings, lambda point: point),
    "trembled": (trembled, lambda point: point),
    "turned": (lambda rings: [[turned(p) for p in ring] for ring in rings], turned),
    "mirrored": (lambda rings: [[mirrored(p) for p in reversed(ring)] for ring in rings], mirrored),
}


def error(server, mesh, drawing, truth, change):
    """The mean error of the match of a drawing so changed; nothing where it is refused, as an outline that crosses itself is."""
    of_rings, of_point = change
    rings = of_rings([drawing["outline"], *drawing.get("holes", [])])
    try:
        sketch = posted(server, "/v1/sketches", {"outline": rings[0], "holes": rings[1:]})
    except urllib.error.HTTPError as refusal:
        print("refused:", json.loads(refusal.read())["detail"])
        return None
    match = posted(server, "/v1/matches", {"mesh": mesh, "sketch": sketch["id"]}, prefer="wait=120")
    pairs = {"side": truth["side"], "points": [of_point(p) for p in truth["points"]], "variants": truth["variants"]}
    judged = posted(server, f"/v1/matches/{match['id']}/evaluations", {"pairs": pairs})
    return judged["pairs"]["coherent"]["mean"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", nargs="+")
    parser.add_argument("--server", default="http://127.0.0.1:8080")
    options = parser.parse_args()
    for cases in options.cases:
        found = []
        for name in sorted(os.listdir(cases)):
            folder = os.path.join(cases, name)
            if not os.path.exists(os.path.join(folder, "truth.json")):
                continue
            read = lambda name: open(os.path.join(folder, name), "rb").read()
            mesh = called(options.server, "POST", "/v1/meshes?format=off", read("mesh.off"), "application/octet-stream")["id"]
            drawing, truth = json.loads(read("sketch.json")), json.loads(read("truth.json"))
            found.append([error(options.server, mesh, drawing, truth, change) for change in CHANGES.values()])
            print(f"{name:60}", *("  -  " if value is None else f"{value:.3f}" for value in found[-1]), flush=True)
        taken = [row for row in found if None not in row]
        means = [sum(column) / len(taken) for column in zip(*taken)]
        told = ", ".join(f"{name} {mean:.4f}" for name, mean in zip(CHANGES, means))
        print(f"{cases}, {len(taken)} of {len(found)} cases, none refused: {told}")


if __name__ == "__main__":
    main()
