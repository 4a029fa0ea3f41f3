#!/usr/bin/env python3
"""How soon a match shows its answer at first sight, and how good that is.

    python3 scripts/previews.py CASES [--server http://127.0.0.1:8080] [--keep DIR]

CASES is a folder with cases.json (name, drawing, type, meshes) and meshes.json (name to file). Every mesh is made ready by a
match with an oval; then every drawing is new to the server when its match is timed: from the POST to the event `preview`, and
to `succeeded`. What --keep writes, DIR/preview and DIR/final, is one answer for each pair, for a
program that judges answers. Exits with 1 where a match shows no answer at first sight. Standard library only.
"""
import argparse
import json
import math
import os
import statistics
import sys
import time
import urllib.error
import urllib.request


def called(server, method, path, body=None, kind=None):
    headers = {"content-type": kind} if kind else {}
    request = urllib.request.Request(server + path, data=body, method=method, headers=headers)
    with urllib.request.urlopen(request, timeout=600) as answer:
        return json.loads(answer.read())


def events(server, path):
    """The data of every event of a stream, as they come."""
    with urllib.request.urlopen(server + path, timeout=600) as stream:
        for line in stream:
            if line.startswith(b"data:"):
                yield json.loads(line[5:])


def followed(server, request):
    """The two answers of a match, and the milliseconds until each was told of."""
    begun = time.monotonic()
    match = called(server, "POST", "/v1/matches", json.dumps(request).encode(), "application/json")
    result, shown, preview = match["links"]["result"], None, None
    for event in events(server, match["links"]["events"]):
        now = 1e3 * (time.monotonic() - begun)
        if event["progress"]["stage"] == "preview" and preview is None:
            answer = called(server, "GET", result + "?preview=true")
            shown, preview = (now, answer) if answer.get("preview") else (None, None)
        if event["status"] == "succeeded":
            return preview, shown, called(server, "GET", result), now
    raise RuntimeError(f"match {match['id']} did not succeed")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("cases")
    parser.add_argument("--server", default="http://127.0.0.1:8080")
    parser.add_argument("--keep")
    options = parser.parse_args()
    read = lambda *path: open(os.path.join(options.cases, *path), "rb").read()
    meshes = json.loads(read("meshes.json"))
    times = {"preview": [], "final": []}
    oval = [[2 * math.cos(math.tau * i / 60), math.sin(math.tau * i / 60)] for i in range(60)]
    oval = called(options.server, "POST", "/v1/sketches", json.dumps({"outline": oval}).encode(), "application/json")
    unseen, ready = 0, set()
    for case in json.loads(read("cases.json")):
        for name in case["meshes"]:
            pair = f"{case['name']}@{name}"
            mesh = called(options.server, "POST", "/v1/meshes", read(meshes[name]["file"]), "application/octet-stream")
            try:
                sketch = called(options.server, "POST", "/v1/sketches", read(case["drawing"]), case["type"])
                for drawing in [oval, sketch][name in ready:]:
                    request = {"mesh": mesh["id"], "sketch": drawing["id"]}
                    preview, shown, final, ended = followed(options.server, request)
                ready.add(name)
            except urllib.error.HTTPError as refused:
                print(f"{pair}: {refused.code} {refused.read().decode()[:120]}")
                continue
            unseen += preview is None
            print(f"{pair:60} {'none' if shown is None else f'{shown:.0f}':>6} {ended:6.0f} ms", flush=True)
            times["final"].append(ended)
            times["preview"] += [shown] if preview else []
            for kind, answer in (("preview", preview), ("final", final)):
                if options.keep and answer:
                    folder = os.path.join(options.keep, kind)
                    os.makedirs(folder, exist_ok=True)
                    kept = {key: answer.get(key) for key in ("correspondences", "rating", "confidence")}
                    kept.update(view=answer["alignment"]["view"], warnings=answer["warnings"], seconds=ended / 1e3)
                    with open(os.path.join(folder, pair + ".json"), "w", encoding="utf-8") as file:
                        json.dump(kept, file)
    for kind, taken in times.items():
        taken.sort()
        print(f"{kind}: {len(taken)} matches, median {statistics.median(taken):.0f} ms, "
              f"95th percentile {taken[int(0.95 * (len(taken) - 1))]:.0f} ms")
    print(f"{unseen} ended before their answer at first sight was seen")
    sys.exit(unseen > 0)


if __name__ == "__main__":
    main()
