#!/usr/bin/env python3
"""How soon a cancelled match lets its thread go: cancels.py --server http://127.0.0.1:8080 [--vertices 100000] [--times 20]

Asks for matches of a new mesh each and cancels them after waits spread over their stages; prints for each the stage and the
milliseconds until the server computes nothing any more, as its measures tell. Exits 1 where one takes longer than --most.
Wants a server that does nothing else, on a machine that does nothing else. Needs Python 3.
"""
import argparse
import http.client
import json
import math
import re
import sys
import time
from urllib.parse import urlsplit


class Server:
    def __init__(self, url):
        self.connection = http.client.HTTPConnection(urlsplit(url).netloc, timeout=120)

    def call(self, method, path, body=None, kind="application/json"):
        self.connection.request(method, path, body, {"Content-Type": kind} if body is not None else {})
        answer = self.connection.getresponse()
        text = answer.read()
        if answer.status >= 300:
            sys.exit(f"{method} {path}: {answer.status} {text.decode()}")
        return text

    def json(self, *request):
        return json.loads(self.call(*request))

    def running(self):
        measures = self.call("GET", "/metrics").decode()
        return float(re.search(r"^sketchmatch_jobs_running (\S+)$", measures, re.M)[1])


def body(vertices, number):
    """A ball with four legs, a head and a tail, a little different for each number, as OBJ."""
    rows = max(8, round(math.sqrt(vertices / 2)))
    columns = 2 * rows
    bumps = [(-0.6, 0.5), (-0.6, 2.6), (-0.6, 3.7), (-0.6, 5.8), (0.3, 0.0), (0.2, math.pi)]
    lines = ["v 0 0 -1", "v 0 0 1"]
    for i in range(1, rows):
        up = -math.pi / 2 + math.pi * i / rows
        for j in range(columns):
            around = 2 * math.pi * j / columns
            reach = 1 + 1e-4 * number * math.sin(3 * up)
            for height, side in bumps:
                away = math.remainder(around - side, 2 * math.pi) * math.cos(up)
                reach += 0.9 * math.exp(-((up - height) ** 2 + away**2) / 0.06)
            x, y, z = math.cos(up) * math.cos(around), math.cos(up) * math.sin(around), math.sin(up)
            lines.append(f"v {reach * x:.6f} {reach * y:.6f} {reach * z:.6f}")
    at = lambda i, j: 3 + (i - 1) * columns + j % columns
    for j in range(columns):
        lines.append(f"f 1 {at(1, j + 1)} {at(1, j)}")
        lines.append(f"f 2 {at(rows - 1, j)} {at(rows - 1, j + 1)}")
        for i in range(1, rows - 1):
            lines.append(f"f {at(i, j)} {at(i, j + 1)} {at(i + 1, j + 1)} {at(i + 1, j)}")
    return "\n".join(lines).encode()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--server", required=True)
    parser.add_argument("--vertices", type=int, default=100_000)
    parser.add_argument("--times", type=int, default=20)
    parser.add_argument("--most", type=float, default=50.0, help="milliseconds")
    given = parser.parse_args()
    server = Server(given.server)
    sketch = server.json("POST", "/v1/sketches", server.call("GET", "/v1/examples/quadruped/sketch"))["id"]

    def asked(number):
        mesh = server.json("POST", "/v1/meshes?format=obj", body(given.vertices, number), "model/obj")["id"]
        match = server.json("POST", "/v1/matches", json.dumps({"mesh": mesh, "sketch": sketch}))["id"]
        while server.json("GET", f"/v1/matches/{match}")["status"] == "queued":
            time.sleep(0.001)
        return match

    whole, begun = asked(0), time.monotonic()
    while server.json("GET", f"/v1/matches/{whole}")["status"] == "running":
        time.sleep(0.01)
    length = time.monotonic() - begun
    print(f"a whole match takes {length:.2f} s")
    waits = []
    for number in range(1, given.times + 1):
        match = asked(number)
        time.sleep(length * (number - 0.5) / given.times)
        stage = server.json("GET", f"/v1/matches/{match}")["progress"]
        told = time.monotonic()
        status = server.json("POST", f"/v1/matches/{match}/cancel")["status"]
        while server.running() > 0:
            pass
        took = (time.monotonic() - told) * 1e3
        print(f"{took:7.1f} ms  {status}  {json.dumps(stage)}")
        if status == "cancelled":
            waits.append(took)
    waits.sort()
    if not waits:
        sys.exit("every match was finished before it was cancelled")
    print(f"{len(waits)} cancelled: median {waits[len(waits) // 2]:.1f} ms, longest {waits[-1]:.1f} ms")
    sys.exit(waits[-1] > given.most)


if __name__ == "__main__":
    main()
