#!/usr/bin/env python3
"""Replays reports of users that need more than one file each: reports.py --reports DIR --server http://127.0.0.1:8080

DIR holds the folders 13-warnings-of-another-upload, 14-http-clients and 17-openapi.
Prints a line for every check; exits 1 where one fails. Needs Python 3; the last check of 17
needs node and the network besides, to generate clients, and is left out with --no-clients.
"""
import argparse
import collections
import http.client
import json
import re
import subprocess
import sys
import threading
import time
import urllib.error
import urllib.request
from pathlib import Path
from urllib.parse import quote, urlsplit

PATIENCE = 30


class Server:
    def __init__(self, url):
        self.url = url.rstrip("/")
        self.place = urlsplit(self.url)

    def call(self, method, path, body=None, kind="application/octet-stream"):
        """Status and JSON of an answer."""
        headers = {"Content-Type": kind} if body is not None else {}
        request = urllib.request.Request(self.url + path, data=body, method=method, headers=headers)
        try:
            with urllib.request.urlopen(request, timeout=PATIENCE) as answer:
                return answer.status, json.load(answer)
        except urllib.error.HTTPError as error:
            return error.code, json.loads(error.read() or b"{}")

    def connection(self):
        return http.client.HTTPConnection(self.place.hostname, self.place.port, timeout=PATIENCE)


def warnings_of_another_upload(server, folder):
    """An answer speaks of the file that was sent, whatever other file has the same shape."""
    pairs = [
        ("meshes", "a-clean.obj", "b-with-repeated-faces.obj", "application/octet-stream", "repeat|duplicate|twice"),
        ("sketches", "d-clean.svg", "c-open-stroke.svg", "image/svg+xml", "open|closed|encloses nothing"),
    ]
    for kind, clean, mended, media_type, said in pairs:
        known = {}
        for turn, file in enumerate([clean, mended, clean, mended]):
            name = f"{file} {turn}"
            path = f"/v1/{kind}?name={quote(name)}"
            status, answer = server.call("POST", path, (folder / file).read_bytes(), media_type)
            yield f"{name}: taken", status in ((200, 201) if turn < 2 else (200,)), status
            yield f"{name}: carries the name given with it", answer.get("name") == name, answer.get("name")
            warnings = json.dumps(answer.get("warnings"))
            wrong = bool(re.search(said, warnings)) != (file == mended)
            yield f"{name}: warned of what was mended in this file", not wrong, warnings
            known[file] = answer.get("id")
        for file, id in known.items():
            status, answer = server.call("GET", f"/v1/{kind}/{id}")
            warnings = json.dumps(answer.get("warnings"))
            wrong = bool(re.search(said, warnings)) != (file == mended)
            yield f"{file}: its document tells the same", status == 200 and not wrong, f"{status} {warnings}"


def http_clients(server, _folder):
    """Slow uploads of unknown length hold up nobody, and many at a time are taken."""
    slow = []
    for _ in range(4):
        connection = server.connection()
        connection.putrequest("POST", "/v1/meshes?format=obj")
        connection.putheader("Transfer-Encoding", "chunked")
        connection.endheaders()
        connection.send(b"8\r\nv 0 0 0\n\r\n")
        slow.append(connection)
    time.sleep(0.5)
    began = time.monotonic()
    triangle = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"
    status, _ = server.call("POST", "/v1/meshes?format=obj", triangle)
    yield "an upload beside four slow ones is taken", status in (200, 201), status
    for path in ("/v1/sketches", "/v1/matches"):
        status, _ = server.call("POST", path, b"{}", "application/json")
        yield f"an empty request to {path} is understood and refused", status == 422, status
    took = time.monotonic() - began
    yield "all of that within ten seconds", took < 10, f"{took:.1f} s"
    for connection in slow:
        connection.close()

    body = grid(54)
    statuses = []

    def upload():
        connection = server.connection()
        pieces = (body[at : at + 8192] for at in range(0, len(body), 8192))
        try:
            connection.request("POST", "/v1/meshes?format=obj", body=pieces)
            statuses.append(connection.getresponse().status)
        except OSError as error:
            statuses.append(repr(error))

    uploads = [threading.Thread(target=upload) for _ in range(12)]
    for thread in uploads:
        thread.start()
    for thread in uploads:
        thread.join()
    good = len(statuses) == 12 and set(statuses) <= {200, 201}
    yield f"twelve chunked uploads of {len(body) // 1000} kB at a time are taken", good, statuses


def grid(side):
    """A square of side² vertices as OBJ."""
    places = range(side)
    vertices = "".join(f"v {x / side:.6f} {y / side:.6f} 0\n" for y in places for x in places)
    corners = [(y * side + x + 1) for y in places[:-1] for x in places[:-1]]
    faces = "".join(f"f {i} {i + 1} {i + side + 1} {i + side}\n" for i in corners)
    return (vertices + faces).encode()


def openapi(server, folder, clients=True):
    """The document is valid and makes clients."""
    status, document = server.call("GET", "/openapi.json")
    yield "the document is there", status == 200, status
    operations = collections.defaultdict(list)
    for path, methods in document["paths"].items():
        for method, operation in methods.items():
            if isinstance(operation, dict) and "operationId" in operation:
                operations[operation["operationId"]].append(f"{method} {path}")
    repeated = {id: places for id, places in operations.items() if len(places) > 1}
    yield "no operation id occurs twice", not repeated, repeated
    for path in ("/v1/meshes", "/v1/sketches"):
        required = document["paths"][path]["post"].get("requestBody", {}).get("required")
        yield f"an upload to {path} has a body", required is True, required
    if clients:
        run = subprocess.run(["sh", str(folder / "check.sh"), server.url], capture_output=True, text=True)
        said = (run.stdout + run.stderr)[-2000:]
        yield "it is valid, and clients are generated from it and compile", run.returncode == 0, said
        for path in ("/v1/matches/{id}", "/v1/matches/{id}/result"):
            calls = re.search(r'"url": "%s"' % re.escape(path), run.stdout)
            yield f"the client calls {path}", calls is not None, said


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--reports", type=Path, required=True)
    parser.add_argument("--server", default="http://127.0.0.1:8080")
    parser.add_argument("--no-clients", action="store_true")
    options = parser.parse_args()
    server = Server(options.server)
    failed = 0
    for folder, checks in {
        "13-warnings-of-another-upload": warnings_of_another_upload(
            server, options.reports / "13-warnings-of-another-upload"
        ),
        "14-http-clients": http_clients(server, options.reports / "14-http-clients"),
        "17-openapi": openapi(server, options.reports / "17-openapi", not options.no_clients),
    }.items():
        try:
            for what, good, found in checks:
                failed += not good
                print(f"{'ok  ' if good else 'FAIL'} {folder[:2]}  {what}" + ("" if good else f": {found}"))
        except (OSError, http.client.HTTPException, LookupError, ValueError) as error:
            failed += 1
            print(f"FAIL {folder[:2]}  {error!r}")
    print(f"{failed} faults")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
