#!/usr/bin/env python3
"""Has nodes work on many small jobs while they are killed, cut off from their database and refused by their blobs; then counts.

    python3 scripts/chaos.py --program target/release/sketchmatch [--jobs 2000] [--nodes 3] [--calm] [--watched]
    python3 scripts/chaos.py --program target/release/sketchmatch --sqlite [--jobs 2000] [--calm] [--watched]

Every second a node drawn by chance is killed (kill -9) and started again. With PostgreSQL and an S3 server, each reached by
way of a gate: three times all connections to the database are cut, and for 30 s the S3 server takes none. With --sqlite it is
one node over a directory of its own, killed every three seconds: as long as one of three lives. Afterwards, with no node running,
the blobs are swept. It fails unless every job that was
accepted succeeded, was published once, and no blob is left that no row names. With --calm nothing is done to the nodes: how
many jobs a second they do. With --watched a Prometheus scrapes the nodes meanwhile, and it fails unless every panel of the
dashboard has something to show and every alert could be evaluated.

Needs a PostgreSQL in which databases can be made (--database), `psql`, and the Python package `moto[s3,server]`; --sqlite needs
neither. --watched needs `prometheus` and `promtool`.
"""
import argparse, collections, contextlib, json, math, os, random, shutil, signal, socket, sqlite3, subprocess, sys, tempfile
import threading, time, urllib.error, urllib.parse, urllib.request
sys.path.insert(0, os.path.dirname(__file__))
from watching import Watch

BUCKET = 'sketches'
REFUSAL = 30  # seconds that the S3 server takes no connections
CUTS = 3      # how often all connections to the database are cut
TROUBLE = (urllib.error.URLError, ConnectionError, TimeoutError, socket.timeout, json.JSONDecodeError, OSError)


def free_port():
    with socket.socket() as s:
        s.bind(('127.0.0.1', 0))
        return s.getsockname()[1]


class Gate:
    """A port whose connections are passed on to another, until they are cut or it is shut."""
    def __init__(self, target):
        self.target, self.open, self.pairs, self.lock = target, True, set(), threading.Lock()
        self.listener = socket.create_server(('127.0.0.1', 0), backlog=128)
        self.port = self.listener.getsockname()[1]
        threading.Thread(target=self.accept, daemon=True).start()

    def accept(self):
        while True:
            client, _ = self.listener.accept()
            if not self.open:
                client.close(); continue
            try: server = socket.create_connection(self.target, timeout=10)
            except OSError: client.close(); continue
            server.settimeout(None)
            pair = (client, server)
            with self.lock: self.pairs.add(pair)
            for a, b in (pair, pair[::-1]): threading.Thread(target=self.pump, args=(a, b, pair), daemon=True).start()

    def pump(self, a, b, pair):
        with contextlib.suppress(OSError):
            while data := a.recv(65536): b.sendall(data)
        self.end(pair)

    def end(self, pair):
        with self.lock: self.pairs.discard(pair)
        for s in pair:
            with contextlib.suppress(OSError): s.shutdown(socket.SHUT_RDWR)
            with contextlib.suppress(OSError): s.close()

    def cut(self):
        with self.lock: pairs = list(self.pairs)
        for pair in pairs: self.end(pair)
        return len(pairs)


def ellipsoid(columns, rows, stretch):
    """An ellipsoid as OBJ, of as many vertices as columns times rows and two."""
    ring = lambda i: [(math.cos(2 * math.pi * j / columns) * math.sin(math.pi * i / (rows + 1)) * stretch,
                       math.cos(math.pi * i / (rows + 1)) * 2, math.sin(2 * math.pi * j / columns) * math.sin(math.pi * i / (rows + 1)))
                      for j in range(columns)]
    points = [(0, 2, 0)] + [p for i in range(1, rows + 1) for p in ring(i)] + [(0, -2, 0)]
    at = lambda i, j: 2 + i * columns + j % columns
    faces = [(1, at(0, j + 1), at(0, j)) for j in range(columns)]
    for i in range(rows - 1):
        for j in range(columns):
            faces += [(at(i, j), at(i, j + 1), at(i + 1, j)), (at(i, j + 1), at(i + 1, j + 1), at(i + 1, j))]
    faces += [(len(points), at(rows - 1, j), at(rows - 1, j + 1)) for j in range(columns)]
    return ''.join('v %.6f %.6f %.6f\n' % p for p in points) + ''.join('f %d %d %d\n' % f for f in faces)


def outline(stretch):
    return {'outline': [[stretch * math.cos(t * math.pi / 24), 2 * math.sin(t * math.pi / 24)] for t in range(48)], 'target_vertices': 100}


class PostgreSQL:
    """Tables in a database of its own behind a gate, blobs in a bucket behind another."""
    rest = 1  # seconds between two kills

    def __init__(self, options, scratch):
        server = urllib.parse.urlsplit(options.database)
        self.name, self.admin = f'sketchmatch_chaos_{os.getpid()}', options.database
        self.psql(self.admin, f'CREATE DATABASE {self.name}')
        target = (server.hostname or '127.0.0.1', server.port or 5432)
        self.direct = server._replace(path='/' + self.name).geturl()
        self.database = Gate(target)
        user = server.netloc.rpartition('@')[0]
        self.url = server._replace(netloc=(user + '@' if user else '') + f'127.0.0.1:{self.database.port}', path='/' + self.name).geturl()
        port = free_port()
        self.moto = subprocess.Popen([sys.executable, '-m', 'moto.server', '-H', '127.0.0.1', '-p', str(port)],
                                     stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.blobs = Gate(('127.0.0.1', port))
        self.environment = {'AWS_ACCESS_KEY_ID': 'chaos', 'AWS_SECRET_ACCESS_KEY': 'chaos', 'AWS_REGION': 'us-east-1', 'AWS_ALLOW_HTTP': 'true',
                            'AWS_ENDPOINT_URL': f'http://127.0.0.1:{self.blobs.port}'}
        import boto3
        self.s3 = boto3.client('s3', endpoint_url=f'http://127.0.0.1:{port}', region_name='us-east-1', aws_access_key_id='chaos',
                               aws_secret_access_key='chaos')
        for _ in range(120):
            try: self.s3.create_bucket(Bucket=BUCKET); break
            except Exception: time.sleep(0.5)
        self.options = ['--database-url', self.url, '--blob-url', f's3://{BUCKET}/chaos', '--data-dir', os.path.join(scratch, 'none')]

    @staticmethod
    def psql(url, sql):
        done = subprocess.run(['psql', '-X', '-q', '-A', '-t', '-F', '\t', '-v', 'ON_ERROR_STOP=1', '-d', url, '-c', sql], capture_output=True, text=True)
        if done.returncode: raise RuntimeError(done.stderr)
        return [line.split('\t') for line in done.stdout.splitlines()]

    def rows(self, sql): return self.psql(self.direct, sql)

    def watch(self):
        self.psql(self.direct, '''CREATE TABLE published (job TEXT);
            CREATE FUNCTION note() RETURNS trigger LANGUAGE plpgsql AS $$ BEGIN INSERT INTO published VALUES (NEW.id); RETURN NULL; END $$;
            CREATE TRIGGER note AFTER UPDATE ON jobs FOR EACH ROW WHEN (NEW.state = 'succeeded' AND OLD.state <> 'succeeded') EXECUTE FUNCTION note()''')

    def names(self):
        pages = self.s3.get_paginator('list_objects_v2').paginate(Bucket=BUCKET, Prefix='chaos/')
        return [blob['Key'].removeprefix('chaos/') for page in pages for blob in page.get('Contents', [])]

    def troubles(self, done):
        """What is done to the servers, by how much of the work is done."""
        def refuse():
            self.blobs.open = False; self.blobs.cut()
            time.sleep(REFUSAL)
            self.blobs.open = True
            return f'the S3 server took no connections for {REFUSAL} s'
        cut = lambda: f'{self.database.cut()} connections to the database were cut'
        return [(0.2, cut), (0.35, refuse), (0.5, cut), (0.75, cut)]

    def close(self):
        self.moto.kill(); self.moto.wait()
        self.psql(self.admin, f'DROP DATABASE {self.name} WITH (FORCE)')


class SQLite:
    """All in one directory, for one node."""
    environment = {}
    rest = 3  # seconds: it lives as long as one of three

    def __init__(self, _, scratch):
        self.data = os.path.join(scratch, 'data')
        self.options = ['--data-dir', self.data]

    def rows(self, sql):
        with contextlib.closing(sqlite3.connect(os.path.join(self.data, 'sketchmatch.db'), timeout=60)) as database:
            rows = database.execute(sql).fetchall(); database.commit()
            return [[str(value) for value in row] for row in rows]

    def watch(self):
        self.rows('CREATE TABLE published (job TEXT)')
        self.rows('''CREATE TRIGGER note AFTER UPDATE ON jobs WHEN NEW.state = 'succeeded' AND OLD.state <> 'succeeded'
                     BEGIN INSERT INTO published VALUES (NEW.id); END''')

    def names(self):
        blobs = os.path.join(self.data, 'blobs')
        return [os.path.relpath(os.path.join(folder, name), blobs) for folder, _, names in os.walk(blobs) for name in names]

    def troubles(self, done): return []

    def close(self): pass


class Node:
    def __init__(self, program, number, store, scratch):
        self.port, self.measures, self.log = free_port(), free_port(), open(os.path.join(scratch, f'node-{number}.log'), 'ab')
        self.command = [program, 'serve', '--workers', '1', '--listen', f'127.0.0.1:{self.port}',
                        '--metrics-listen', f'127.0.0.1:{self.measures}', '--max-queue', '100000', *store.options]
        self.environment = {**os.environ, **store.environment, 'MALLOC_ARENA_MAX': '2'}
        self.start()

    def start(self): self.process = subprocess.Popen(self.command, env=self.environment, stderr=self.log)

    def kill(self): self.process.kill(); self.process.wait()

    def url(self, path): return f'http://127.0.0.1:{self.port}{path}'


def asked(nodes, method, path, body=None, headers={}, patience=600):
    """The answer of any node, asked again and again while there is none: the same key makes the same request."""
    end = time.time() + patience
    while time.time() < end:
        request = urllib.request.Request(random.choice(nodes).url(path), data=body, method=method, headers=headers)
        try:
            with urllib.request.urlopen(request, timeout=30) as answer: return json.load(answer)
        except urllib.error.HTTPError as error:
            if error.code not in (429, 500, 503, 507): raise RuntimeError(f'{method} {path}: {error.code} {error.read()[:500]}')
            time.sleep(0.2)
        except TROUBLE: time.sleep(0.2)
    raise RuntimeError(f'{method} {path}: no answer for {patience} s')


def submit(nodes, count, shapes):
    """The ids of so many jobs, each asked for under a key of its own, by eight clients at a time."""
    ids, keys, lock = {}, iter(range(count)), threading.Lock()
    def client():
        while True:
            with lock: key = next(keys, None)
            if key is None: return
            mesh, sketch = shapes[key % len(shapes)]
            halves = lambda shape: [2 * i // shape['vertices'] for i in range(shape['vertices'])]
            request = {'mesh': mesh['id'], 'sketch': sketch['id'], 'preset': 'thesis', 'basis': {'k': 5}, 'weights': {'method': 'none'},
                       'descriptors': {'hks': {'count': 5}, 'wks': {'count': 5}},
                       'regions': {'method': 'given', 'sketch': halves(sketch), 'mesh': halves(mesh)},
                       'regulariser': {'type': 'l1', 'max_iterations': 2}}
            answer = asked(nodes, 'POST', f'/v1/matches?name={key}', json.dumps(request).encode(),
                           {'Content-Type': 'application/json', 'Idempotency-Key': f'chaos-{key}'})
            with lock: ids[key] = answer['id']
    clients = [threading.Thread(target=client, daemon=True) for _ in range(8)]
    for thread in clients: thread.start()
    return ids, clients


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument('--program', required=True); p.add_argument('--jobs', type=int, default=2000); p.add_argument('--nodes', type=int, default=3)
    p.add_argument('--sqlite', action='store_true'); p.add_argument('--calm', action='store_true'); p.add_argument('--seed', type=int, default=1)
    p.add_argument('--watched', action='store_true')
    p.add_argument('--database', default='postgres://postgres@127.0.0.1:5432/postgres'); p.add_argument('--patience', type=float, default=3600)
    o = p.parse_args(); chance = random.Random(o.seed)
    scratch = tempfile.mkdtemp(prefix='sketchmatch-chaos-')
    store = (SQLite if o.sqlite else PostgreSQL)(o, scratch)
    nodes, watch = [], None
    try:
        nodes += [Node(o.program, number, store, scratch) for number in range(1 if o.sqlite else o.nodes)]
        asked(nodes, 'GET', '/readyz')
        store.watch()
        if o.watched: watch = Watch([node.measures for node in nodes], free_port(), scratch)
        shapes = []
        for i in range(5):
            mesh = asked(nodes, 'POST', '/v1/meshes?format=obj', ellipsoid(8, 5, 1 + i / 10).encode())
            sketch = asked(nodes, 'POST', '/v1/sketches', json.dumps(outline(1 + i / 10)).encode(), {'Content-Type': 'application/json'})
            shapes.append((mesh, sketch))
        begun = time.time()
        ids, clients = submit(nodes, o.jobs, shapes)
        troubles, kills, told, last = store.troubles(o.jobs) if not o.calm else [], 0, [], begun
        trouble = None
        ended = lambda: int(store.rows("SELECT count(*) FROM jobs WHERE state NOT IN ('queued', 'running')")[0][0])
        done = 0
        while done < o.jobs:
            if time.time() - begun > o.patience: raise RuntimeError(f'{done} of {o.jobs} jobs ended in {o.patience} s')
            time.sleep(store.rest)
            if not o.calm:
                node = chance.choice(nodes); node.kill(); node.start(); kills += 1
            done = ended()
            if troubles and done >= troubles[0][0] * o.jobs and not (trouble and trouble.is_alive()):
                _, do = troubles.pop(0)
                trouble = threading.Thread(target=lambda: told.append(do()), daemon=True); trouble.start()
            if time.time() - last > 30: last = time.time(); print(f'{last - begun:5.0f} s: {done} jobs ended, {kills} kills', flush=True)
        took = time.time() - begun
        for thread in clients: thread.join(timeout=60)
        if trouble: trouble.join(timeout=60)
        words, unseen = watch.seen() if watch else ('', [])
        for node in nodes: node.process.send_signal(signal.SIGTERM)
        for node in nodes: node.process.wait(timeout=60)
        environment = {**os.environ, **store.environment}
        swept = subprocess.run([o.program, 'sweep', '--older-than', '0s', *store.options], env=environment, capture_output=True, text=True, check=True)
        states = collections.Counter({state: int(count) for state, count in store.rows('SELECT state, count(*) FROM jobs GROUP BY state')})
        published = collections.Counter(job for job, in store.rows('SELECT job FROM published'))
        named = {name for name, in store.rows('SELECT geometry_blob FROM shapes UNION SELECT file FROM shapes UNION SELECT result FROM jobs WHERE result IS NOT NULL')}
        blobs = [name for name in store.names() if name.split('/')[0] in ('shapes', 'files', 'results')]
        orphans, missing = set(blobs) - named, named - set(blobs)
        stored = {job for job, in store.rows('SELECT id FROM jobs')}
        lost, twice = set(ids.values()) - stored, [job for job, count in published.items() if count > 1]
        tries = store.rows('SELECT max(attempt), sum(attempt) FROM jobs')[0]
        where = 'SQLite' if o.sqlite else 'PostgreSQL and S3'
        print(f'{where}, {len(nodes)} nodes, {os.cpu_count()} cores: {len(ids)} jobs accepted, {sum(states.values())} in the queue, {dict(states)} in {took:.0f} s ({o.jobs / took:.1f} a second)')
        for line in [f'{kills} kills (kill -9)'] * bool(kills) + told: print('  ' + line)
        print(f'  {tries[1]} attempts, at most {tries[0]} of one job; {swept.stdout.strip()}')
        print(f'  {len(lost)} lost, {len(twice)} published twice, {len(orphans)} orphan blobs after the sweep, {len(missing)} blobs missing')
        if watch: print('  ' + words)
        good = len(ids) == sum(states.values()) == states['succeeded'] == len(published) == o.jobs
        if not good or lost or twice or orphans or missing or unseen: sys.exit(f'FAILED {"; ".join(unseen)}; logs of the nodes in {scratch}')
        shutil.rmtree(scratch)
    finally:
        for node in nodes: node.kill()
        if watch: watch.close()
        store.close()


if __name__ == '__main__': main()
