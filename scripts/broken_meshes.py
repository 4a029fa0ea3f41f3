#!/usr/bin/env python3
"""Matches meshes that were broken as files from the wild are, and writes the answers for the unbroken ones.

    python3 scripts/broken_meshes.py --server http://127.0.0.1:8080 --out DIR [--faults seams,noise] CASE...

A CASE is a folder with mesh.off and sketch.json. The old vertices keep their numbers, copies come after them; an answer that
names a copy is brought back to its original. DIR/<fault>/<case>.json is a result that a scoring script can read as if the
mesh had never been broken. Needs numpy.

One piece, broken:
  seams      cut along two planes, the vertices there doubled
  noise      the same, the copies moved by up to 1e-7 of the diagonal
  slivers    a vertex in the middle of 100 edges, and the triangle without area that fills the crack; 100 faces twice
  detached   every twentieth face on vertices of its own
  flipped    every tenth face turned over
  holes      every fiftieth face missing
In parts, about eight of them:
  touching   each on vertices of its own, moved by a thousandth of the diagonal
  overlapping  each grown by three rings of faces as well
  inside     the mesh whole, and three balls in it
  gap1 ... gap5  each moved away from the middle, so that gaps are up to so many hundredths of the diagonal wide
"""
import argparse, json, os, urllib.error, urllib.request
import numpy as np

SEED = 20240


def call(server, method, path, body=None, kind='application/json'):
    request = urllib.request.Request(server + path, data=body, method=method, headers={'Content-Type': kind, 'Prefer': 'wait=60'})
    try:
        with urllib.request.urlopen(request, timeout=600) as answer: return answer.status, json.load(answer)
    except urllib.error.HTTPError as error: return error.code, json.loads(error.read())


def read_off(path):
    words = open(path).read().split(); n, f = int(words[1]), int(words[2])
    positions = np.array(words[4:4 + 3 * n], float).reshape(n, 3)
    return positions, np.array(words[4 + 3 * n:4 + 3 * n + 4 * f], int).reshape(f, 4)[:, 1:]


def obj(positions, faces):
    return (''.join('v %.17g %.17g %.17g\n' % tuple(p) for p in positions)
            + ''.join('f %d %d %d\n' % tuple(f + 1) for f in faces)).encode()


def diagonal(positions): return np.linalg.norm(np.ptp(positions, axis=0))


def on_own_vertices(positions, faces, chart):
    """The faces of every chart on vertices of its own; the first chart that names a vertex keeps it. Originals of all."""
    original, known, out = list(range(len(positions))), {}, faces.copy()
    for f, face in enumerate(faces):
        for c, v in enumerate(face):
            chart_of_first = known.setdefault(v, {chart[f]: v})
            if chart[f] not in chart_of_first:
                chart_of_first[chart[f]] = len(original); original.append(v)
            out[f, c] = chart_of_first[chart[f]]
    original = np.array(original)
    return positions[original], out, original


def planes(positions, faces):
    middles = positions[faces].mean(axis=1); order = np.argsort(np.ptp(positions, axis=0))
    return sum((middles[:, axis] > np.median(middles[:, axis])) * 2 ** i for i, axis in enumerate(order[1:]))


def parts(positions, faces, count=8):
    """A part for every face: that of the nearest of points as far from each other as can be."""
    middles = positions[faces].mean(axis=1); seeds = [int(np.linalg.norm(middles - middles.mean(0), axis=1).argmax())]
    while len(seeds) < count:
        seeds.append(int(np.min([np.linalg.norm(middles - middles[s], axis=1) for s in seeds], axis=0).argmax()))
    return np.argmin([np.linalg.norm(middles - middles[s], axis=1) for s in seeds], axis=0)


def ball(middle, radius, rows=12, columns=18):
    points, faces = [], []
    for i in range(rows + 1):
        for j in range(columns):
            a, b = np.pi * i / rows, 2 * np.pi * j / columns
            points.append(middle + radius * np.array([np.sin(a) * np.cos(b), np.sin(a) * np.sin(b), np.cos(a)]))
    for i in range(rows):
        for j in range(columns):
            a, b, c, d = i * columns + j, (i + 1) * columns + j, (i + 1) * columns + (j + 1) % columns, i * columns + (j + 1) % columns
            faces += [[a, b, c], [a, c, d]]
    return np.array(points), np.array(faces)


def seams(positions, faces, _): return on_own_vertices(positions, faces, planes(positions, faces))


def noise(positions, faces, random):
    moved, faces, original = seams(positions, faces, random); copies = np.arange(len(positions), len(moved))
    moved[copies] += random.uniform(-1e-7, 1e-7, (len(copies), 3)) * diagonal(positions)
    return moved, faces, original


def slivers(positions, faces, random):
    points, out, original = list(positions), list(faces), list(range(len(positions)))
    for f in random.choice(len(faces), min(100, len(faces)), replace=False):
        a, b, c = faces[f]; m = len(points)
        points.append((positions[a] + positions[b]) / 2); original.append(a)
        out[f] = [a, m, c]; out += [[m, b, c], [a, b, m], [c, a, c]]
    return np.array(points), np.array(out), np.array(original)


def detached(positions, faces, random):
    chart = np.zeros(len(faces), int); single = random.choice(len(faces), len(faces) // 20, replace=False)
    chart[single] = 1 + np.arange(len(single))
    order = np.argsort(chart > 0, kind='stable')
    moved, out, original = on_own_vertices(positions, faces[order], chart[order])
    return moved, out, original


def flipped(positions, faces, random):
    out = faces.copy(); turned = random.choice(len(faces), len(faces) // 10, replace=False)
    out[turned] = out[turned][:, ::-1]
    return positions, out, np.arange(len(positions))


def holes(positions, faces, random):
    missing = random.choice(len(faces), len(faces) // 50, replace=False)
    return positions, np.delete(faces, missing, axis=0), np.arange(len(positions))


def in_parts(positions, faces, by, grown=0):
    part = parts(positions, faces); middle = positions.mean(axis=0); points, out, original = list(positions), [], list(range(len(positions)))
    for p in range(part.max() + 1):
        belongs = part == p
        for _ in range(grown):
            on = np.zeros(len(positions), bool); on[faces[belongs]] = True; belongs = on[faces].any(axis=1)
        own = np.unique(faces[belongs]); away = positions[own].mean(axis=0) - middle
        number = np.full(len(positions), -1); number[own] = len(points) + np.arange(len(own))
        points += list(positions[own] + by * diagonal(positions) * away / max(np.linalg.norm(away), 1e-12)); original += list(own)
        out.append(number[faces[belongs]])
    return np.array(points), np.concatenate(out), np.array(original)


def inside(positions, faces, random):
    """Balls about the middles of three random vertices and their opposites: anywhere in the body."""
    points, out, original = [positions], [faces], [np.arange(len(positions))]; start = len(positions)
    for v in random.choice(len(positions), 3, replace=False):
        near = np.argsort(np.linalg.norm(positions - positions[v], axis=1))[:len(positions) // 20]
        more, more_faces = ball(positions[near].mean(axis=0), 0.01 * diagonal(positions))
        points.append(more); out.append(more_faces + start); original.append(np.full(len(more), v)); start += len(more)
    return np.concatenate(points), np.concatenate(out), np.concatenate(original)


FAULTS = {
    'none': lambda p, f, r: (p, f, np.arange(len(p))), 'seams': seams, 'noise': noise, 'slivers': slivers, 'detached': detached,
    'flipped': flipped, 'holes': holes, 'touching': lambda p, f, r: in_parts(p, f, 1e-3), 'overlapping': lambda p, f, r: in_parts(p, f, 1e-3, 3),
    'inside': inside, **{f'gap{g}': lambda p, f, r, g=g: in_parts(p, f, g / 200) for g in range(1, 6)},
}


def match(server, case, mesh):
    status, mesh = call(server, 'POST', '/v1/meshes?format=obj', mesh, 'application/octet-stream')
    if status not in (200, 201): return None, f'mesh refused: {json.dumps(mesh)[:200]}'
    status, sketch = call(server, 'POST', '/v1/sketches', open(os.path.join(case, 'sketch.json'), 'rb').read())
    status, job = call(server, 'POST', '/v1/matches', json.dumps({'mesh': mesh['id'], 'sketch': sketch['id']}).encode())
    while job.get('status') in ('queued', 'running'): status, job = call(server, 'GET', '/v1/matches/' + job['id'])
    if job.get('status') != 'succeeded': return None, f'no match: {json.dumps(job)[:200]}'
    return call(server, 'GET', f"/v1/matches/{job['id']}/result")[1], mesh


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument('cases', nargs='+', metavar='CASE'); p.add_argument('--server', default='http://127.0.0.1:8080')
    p.add_argument('--out', required=True); p.add_argument('--faults', default=','.join(FAULTS)); o = p.parse_args()
    for fault in o.faults.split(','):
        os.makedirs(os.path.join(o.out, fault), exist_ok=True)
        for case in o.cases:
            name = os.path.basename(case.rstrip('/')); positions, faces = read_off(os.path.join(case, 'mesh.off'))
            points, broken, original = FAULTS[fault](positions, faces, np.random.default_rng(SEED))
            result, mesh = match(o.server, case, obj(points, broken))
            if result is None: print(f'{fault:12s} {name}: {mesh}', flush=True); continue
            for answer in result['correspondences']: answer['mesh_vertex'] = int(original[answer['mesh_vertex']])
            json.dump(result, open(os.path.join(o.out, fault, name + '.json'), 'w'))
            told = ', '.join(w['code'] for w in mesh['warnings'])
            print(f"{fault:12s} {name}: {mesh['components']} components, rated {result.get('rating')}, "
                  f"{result['request'].get('components', '')} {told}", flush=True)


if __name__ == '__main__': main()
