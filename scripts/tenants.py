#!/usr/bin/env python3
"""Whether a tenant can tell by the time of an answer that another has what it asks for.

    python3 scripts/tenants.py target/release/sketchmatch

Starts the program with two tenants, of which one has a mesh, a sketch and a match, and has the other ask for them and for what
nobody has, by turns. Fails where the medians are more than 50 microseconds apart.
"""
import http.client
import json
import re
import statistics
import subprocess
import sys
import tempfile
import time
import uuid

REQUESTS = 2000
APART = 50e-6


def key(program, data, tenant):
    made = subprocess.run([program, 'keys', 'add', '--tenant', tenant, '--data-dir', data], capture_output=True, text=True, check=True)
    return made.stdout.strip()


def answered(connection, method, path, key, body=None):
    headers = {'Authorization': f'Bearer {key}', 'Content-Type': 'application/json'}
    begun = time.perf_counter()
    connection.request(method, path, body, headers)
    answer = connection.getresponse()
    said = answer.read()
    return time.perf_counter() - begun, answer.status, said


def octahedron():
    corners = ['1 0 0', '-1 0 0', '0 2 0', '0 -2 0', '0 0 3', '0 0 -3']
    faces = ['1 3 5', '3 2 5', '2 4 5', '4 1 5', '3 1 6', '2 3 6', '4 2 6', '1 4 6']
    return ''.join(f'v {corner}\n' for corner in corners) + ''.join(f'f {face}\n' for face in faces)


def main(program):
    with tempfile.TemporaryDirectory() as data:
        owner, stranger = (key(program, data, tenant) for tenant in ('owner', 'stranger'))
        serving = subprocess.Popen(
            [program, 'serve', '--listen', '127.0.0.1:0', '--data-dir', data, '--log-format', 'json',
             '--tenant-requests-per-second', '0'], stderr=subprocess.PIPE, text=True)
        try:
            address = next(found[1] for line in serving.stderr if (found := re.search(r'"address":"([^"]+)"', line)))
            # What follows is not read, which holds up nothing.
            connection = http.client.HTTPConnection(address)
            mesh = json.loads(answered(connection, 'POST', '/v1/meshes?format=obj', owner, octahedron())[2])['id']
            drawing = json.dumps({'outline': [[0, 0], [4, 0], [4, 3], [0, 3]]})
            sketch = json.loads(answered(connection, 'POST', '/v1/sketches', owner, drawing)[2])['id']
            asked = json.dumps({'mesh': mesh, 'sketch': sketch, 'basis': {'k': 4}})
            match = json.loads(answered(connection, 'POST', '/v1/matches', owner, asked)[2])['id']
            return sum(compared(connection, stranger, noun, there, nowhere) for noun, there, nowhere in [
                ('meshes', mesh, 'mesh_' + uuid.uuid4().hex),
                ('sketches', sketch, 'sketch_' + uuid.uuid4().hex),
                ('matches', match, str(uuid.uuid4())),
            ])
        finally:
            serving.terminate()
            serving.wait()


def compared(connection, stranger, noun, there, nowhere):
    """1 where what is there can be told by the time from what is not, else 0."""
    times = {there: [], nowhere: []}
    for _ in range(REQUESTS):
        for name, taken in times.items():
            seconds, status, _ = answered(connection, 'GET', f'/v1/{noun}/{name}', stranger)
            assert status == 404, status
            taken.append(seconds)
    elsewhere, missing = (statistics.median(taken) for taken in times.values())
    print(f'{noun}: elsewhere {elsewhere * 1e6:.0f} us, nowhere {missing * 1e6:.0f} us, '
          f'{(elsewhere - missing) * 1e6:+.1f} us apart')
    return int(abs(elsewhere - missing) > APART)


if __name__ == '__main__':
    sys.exit(main(sys.argv[1]))
