#!/usr/bin/env python3
"""Asks a server for ten times the jobs it can do, for a minute; looks at its memory, its refusals, and how fast it tells of a job.

    python3 scripts/overload.py target/release/sketchmatch [--seconds 60] [--times 10] [--p99 10]

It fails unless every job that was accepted succeeded, every refusal was 429 or 503 with Retry-After, the memory of the last third
of the time is within a tenth of that of the middle third, and 99 of 100 questions for a job were answered within --p99 ms.
"""
import argparse, collections, http.client, json, os, shutil, signal, subprocess, sys, tempfile, threading, time
sys.path.insert(0, os.path.dirname(__file__))
from chaos import ellipsoid, free_port, outline

CLIENTS = 32  # connections that ask for jobs


class Client:
    """A connection that is kept."""
    def __init__(self, port): self.connection = http.client.HTTPConnection('127.0.0.1', port, timeout=60)

    def ask(self, method, path, body=None, headers={}):
        self.connection.request(method, path, body, headers)
        answer = self.connection.getresponse()
        return answer.status, dict((name.lower(), value) for name, value in answer.getheaders()), answer.read()


def main():
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument('program'); p.add_argument('--seconds', type=float, default=60); p.add_argument('--times', type=float, default=10)
    p.add_argument('--p99', type=float, default=10)
    o = p.parse_args()
    scratch, port = tempfile.mkdtemp(prefix='sketchmatch-overload-'), free_port()
    log = open(os.path.join(scratch, 'log'), 'wb')
    server = subprocess.Popen([o.program, 'serve', '--listen', f'127.0.0.1:{port}', '--data-dir', scratch + '/data', '--max-queue', '200'], stderr=log)
    try:
        for _ in range(200):
            try:
                if Client(port).ask('GET', '/readyz')[0] == 200: break
            except OSError: pass
            time.sleep(0.1)
        one = Client(port)
        mesh = json.loads(one.ask('POST', '/v1/meshes?format=obj', ellipsoid(20, 16, 1.2))[2])
        sketch = json.loads(one.ask('POST', '/v1/sketches', json.dumps(outline(1.2)), {'Content-Type': 'application/json'})[2])
        request = json.dumps({'mesh': mesh['id'], 'sketch': sketch['id']})
        ask = lambda client, wait=False: client.ask('POST', '/v1/matches', request, {'Content-Type': 'application/json', **({'Prefer': 'wait=60'} if wait else {})})
        ask(one, wait=True)
        # What it can do: as many clients as processors, one job after the other.
        done, begun = collections.Counter(), time.time()
        def calm():
            client = Client(port)
            while time.time() - begun < 10: ask(client, wait=True); done['jobs'] += 1
        threads = [threading.Thread(target=calm) for _ in range(os.cpu_count())]
        for t in threads: t.start()
        for t in threads: t.join()
        capacity = done['jobs'] / (time.time() - begun); rate = o.times * capacity
        ids, told, bad, lock = [], collections.Counter(), [], threading.Lock()
        begun = time.time(); tickets = iter(range(10 ** 9))
        def press():
            client = Client(port)
            while True:
                with lock: due = begun + next(tickets) / rate
                if due - begun > o.seconds: return
                time.sleep(max(0, due - time.time()))
                status, headers, body = ask(client)
                with lock:
                    told[status] += 1
                    if status == 202: ids.append(json.loads(body)['id'])
                    elif status not in (429, 503) or 'retry-after' not in headers: bad.append((status, body[:200]))
        threads = [threading.Thread(target=press) for _ in range(CLIENTS)]
        for t in threads: t.start()
        times, memory, last = [], [], 0
        status = Client(port)
        while any(t.is_alive() for t in threads):
            if ids:
                asked = time.perf_counter(); answer, _, _ = status.ask('GET', '/v1/matches/' + ids[-1])
                times.append(1e3 * (time.perf_counter() - asked))
                if answer != 200: bad.append((answer, 'of a job'))
            if time.time() - last >= 1:
                last = time.time(); memory.append(int(open(f'/proc/{server.pid}/statm').read().split()[1]) * os.sysconf('SC_PAGE_SIZE') / 2 ** 20)
            time.sleep(0.02)
        took = time.time() - begun
        ends, after = collections.Counter(), Client(port)
        for id in ids:
            while (document := json.loads(after.ask('GET', '/v1/matches/' + id)[2]))['status'] in ('queued', 'running'): time.sleep(0.2)
            ends[document['status']] += 1
        times.sort(); third = len(memory) // 3
        middle, late = max(memory[third:2 * third]), max(memory[2 * third:])
        p99 = times[int(0.99 * len(times))]
        print(f'{os.cpu_count()} cores, load {os.getloadavg()[0]:.0f}: {capacity:.1f} jobs a second when calm, {rate:.0f} asked for in each of {took:.0f} s')
        print(f'  answers {dict(told)}; accepted jobs ended {dict(ends)}')
        print(f'  {len(times)} questions for a job: half within {times[len(times) // 2]:.1f} ms, 99 of 100 within {p99:.1f} ms, all within {times[-1]:.0f} ms')
        print('  memory in MiB, every fifth second: ' + ' '.join(f'{m:.0f}' for m in memory[::5]))
        wrong = [f'{len(bad)} answers such as {answer}' for answer in bad[:1]] + ['accepted jobs did not succeed'] * (set(ends) != {'succeeded'})
        wrong += ['memory grows'] * (late > 1.1 * middle) + ['questions are answered late'] * (p99 > o.p99)
        if wrong: sys.exit(f'FAILED: {"; ".join(wrong)}; log in {scratch}')
        shutil.rmtree(scratch)
    finally:
        server.send_signal(signal.SIGTERM); server.wait()


if __name__ == '__main__': main()
