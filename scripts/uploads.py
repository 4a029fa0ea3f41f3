#!/usr/bin/env python3
"""Uploads every mesh file under a folder and says what became of it: taken, mended (what), refused (why), and how long.

    python3 scripts/uploads.py --server http://127.0.0.1:8080 FOLDER [--match SKETCH]

With --match the meshes that are taken are matched with a sketch (JSON) too. A line for each file, then how many of each kind.
"""
import argparse, collections, json, os, time, urllib.error, urllib.request

FORMATS = {'.obj', '.off', '.ply', '.stl', '.glb', '.gltf'}
TOLD = {'several_components', 'isolated_specks', 'unreferenced_vertices', 'ignored_elements'}


def post(server, path, body, kind='application/octet-stream'):
    request = urllib.request.Request(server + path, data=body, method='POST', headers={'Content-Type': kind, 'Prefer': 'wait=60'})
    try:
        with urllib.request.urlopen(request, timeout=600) as answer: return answer.status, json.load(answer)
    except urllib.error.HTTPError as error: return error.code, json.loads(error.read())


def why(problem):
    faults = [' '.join(filter(None, (fault.get('place'), fault.get('detail')))) for fault in problem.get('errors', [])]
    return '; '.join([problem.get('detail', '')] + faults[:2]) + (f' (and {len(faults) - 2} more)' if len(faults) > 2 else '')


def uploaded(server, path):
    """The mesh as it was taken, or nothing; what became of it in a word and in a line."""
    begun = time.time()
    status, answer = post(server, '/v1/meshes?format=' + os.path.splitext(path)[1][1:].lower(), open(path, 'rb').read())
    took = f'{time.time() - begun:.2f} s'
    if status not in (200, 201): return None, 'refused', f'{status} {why(answer)}, {took}'
    mends = [warning['code'] for warning in answer['warnings'] if warning['code'] not in TOLD]
    size = f"{answer['triangles']} triangles in {answer['components']} components, {'closed' if answer['closed'] else 'open'}"
    return answer, 'mended' if mends else 'taken', ', '.join([size, *mends, took])


def matched(server, mesh, sketch):
    begun = time.time()
    _, job = post(server, '/v1/matches', json.dumps({'mesh': mesh, 'sketch': sketch}).encode(), 'application/json')
    while job.get('status') in ('queued', 'running'):
        with urllib.request.urlopen(f"{server}/v1/matches/{job['id']}?wait=60") as answer: job = json.load(answer)
    return f"{job.get('status', 'not queued')} {why(job.get('error') or job) if job.get('status') != 'succeeded' else ''}, {time.time() - begun:.1f} s"


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument('folder'); p.add_argument('--server', default='http://127.0.0.1:8080'); p.add_argument('--match'); o = p.parse_args()
    sketch = o.match and post(o.server, '/v1/sketches', open(o.match, 'rb').read(), 'application/json')[1]['id']
    kinds = collections.Counter()
    for folder, _, names in sorted(os.walk(o.folder)):
        for name in sorted(name for name in names if os.path.splitext(name)[1].lower() in FORMATS):
            mesh, kind, line = uploaded(o.server, os.path.join(folder, name)); kinds[kind] += 1
            if mesh and sketch: line += '; matched: ' + matched(o.server, mesh['id'], sketch)
            print(f'{kind:8s} {os.path.relpath(os.path.join(folder, name), o.folder)}: {line}', flush=True)
    print(', '.join(f'{count} {kind}' for kind, count in kinds.most_common()))


if __name__ == '__main__': main()
