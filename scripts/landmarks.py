#!/usr/bin/env python3
"""What clicks mend: matches of silhouettes whose truth is known, without landmarks and with three and eight true ones.

    python3 scripts/landmarks.py CASES [CASES ...] [--server http://127.0.0.1:8080] [--worst 5]

Every folder of CASES holds mesh.off, sketch.json and truth.json. Clicks are the truth's points farthest from each other in the
drawing, the first at its extremity, in the reading of the drawing that the answer without them is nearest to. Errors are
those of `POST /v1/matches/{id}/evaluations`: the mean geodesic distance in units of the square root of the area, of the
reading that fits best as a whole. Standard library only.
"""
import argparse
import json
import os
import urllib.request

CLICKS = [0, 3, 8]


def called(server, method, path, body=None, kind="application/json", **headers):
    request = urllib.request.Request(server + path, data=body, method=method, headers={"content-type": kind, **headers})
    with urllib.request.urlopen(request, timeout=600) as answer:
        return json.loads(answer.read())


def posted(server, path, value, **headers):
    return called(server, "POST", path, json.dumps(value).encode(), **headers)


def apart(points, count):
    """Numbers of so many points far from each other, the first farthest from their middle."""
    middle = [sum(p[axis] for p in points) / len(points) for axis in (0, 1)]
    away = lambda p, q: (p[0] - q[0]) ** 2 + (p[1] - q[1]) ** 2
    chosen = [max(range(len(points)), key=lambda i: away(points[i], middle))]
    while len(chosen) < count:
        chosen.append(max(range(len(points)), key=lambda i: min(away(points[i], points[j]) for j in chosen)))
    return chosen


def errors(server, folder):
    """The mean errors of a case by number of clicks."""
    read = lambda name: open(os.path.join(folder, name), "rb").read()
    mesh = called(server, "POST", "/v1/meshes?format=off", read("mesh.off"), "application/octet-stream")
    sketch = called(server, "POST", "/v1/sketches", read("sketch.json"))
    truth = json.loads(read("truth.json"))
    pairs = {name: truth[name] for name in ("side", "points", "variants")}
    found, reading = {}, None
    for count in CLICKS:
        clicks = [
            {"sketch": truth["points"][i], "mesh": truth["variants"][reading][i]}
            for i in (apart(truth["points"], count) if count else [])
        ]
        request = {"mesh": mesh["id"], "sketch": sketch["id"], "landmarks": clicks}
        match = posted(server, "/v1/matches", request, prefer="wait=120")
        judged = posted(server, f"/v1/matches/{match['id']}/evaluations", {"pairs": pairs})
        found[count] = judged["pairs"]["coherent"]["mean"]
        reading = reading or judged["pairs"]["best"]
    return found


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases", nargs="+")
    parser.add_argument("--server", default="http://127.0.0.1:8080")
    parser.add_argument("--worst", type=int, default=5)
    options = parser.parse_args()
    folders = [os.path.join(cases, name) for cases in options.cases for name in sorted(os.listdir(cases))]
    found = []
    for folder in folders:
        if os.path.exists(os.path.join(folder, "truth.json")):
            found.append((os.path.basename(folder), errors(options.server, folder)))
            print(f"{found[-1][0]:60}", *(f"{found[-1][1][count]:.3f}" for count in CLICKS), flush=True)
    found.sort(key=lambda case: -case[1][0])
    for title, cases in ("all", found), (f"the {options.worst} worst", found[: options.worst]):
        means = {count: sum(case[1][count] for case in cases) / len(cases) for count in CLICKS}
        mended = ", ".join(f"{count} clicks mend {100 * (1 - means[count] / means[0]):.0f} %" for count in CLICKS[1:])
        print(f"{title}, {len(cases)} cases: {means[0]:.4f} without clicks; {mended}")


if __name__ == "__main__":
    main()
