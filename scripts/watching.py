#!/usr/bin/env python3
"""Has a Prometheus watch a server at work, and asks it for every panel of the dashboard and every alert.

    python3 scripts/watching.py target/release/sketchmatch

It fails unless every panel has something to show and no rule has an error. Needs `prometheus` and `promtool` on the PATH.
"""
import json, os, shutil, signal, subprocess, sys, tempfile, time, urllib.parse, urllib.request
sys.path.insert(0, os.path.dirname(__file__))
from chaos import ellipsoid, free_port, outline

DEPLOY = os.path.join(os.path.dirname(os.path.abspath(__file__)), '..', 'deploy')


def asked(url, body=None, headers={}):
    with urllib.request.urlopen(urllib.request.Request(url, data=body, headers=headers), timeout=60) as answer: return json.load(answer)


def soon(what, seconds=60):
    end = time.time() + seconds
    while True:
        try:
            if found := what(): return found
        except OSError: pass
        if time.time() > end: sys.exit(f'nothing came within {seconds} s')
        time.sleep(0.2)


def main():
    program = sys.argv[1]
    rules = os.path.join(DEPLOY, 'prometheus')
    for check in (['check', 'rules', 'alerts.yaml'], ['test', 'rules', 'alerts_test.yaml']): subprocess.run(['promtool', *check], cwd=rules, check=True)
    scratch = tempfile.mkdtemp(prefix='sketchmatch-watching-')
    port, measures, watcher = free_port(), free_port(), free_port()
    shutil.copy(os.path.join(rules, 'alerts.yaml'), scratch)
    with open(os.path.join(scratch, 'prometheus.yaml'), 'w') as f:
        json.dump({'global': {'scrape_interval': '1s', 'evaluation_interval': '1s'}, 'rule_files': ['alerts.yaml'],
                   'scrape_configs': [{'job_name': 'sketchmatch', 'static_configs': [{'targets': [f'127.0.0.1:{measures}']}]}]}, f)
    log = open(os.path.join(scratch, 'log'), 'wb')
    server = subprocess.Popen([program, 'serve', '--listen', f'127.0.0.1:{port}', '--metrics-listen', f'127.0.0.1:{measures}', '--data-dir', scratch + '/data'], stderr=log)
    prometheus = subprocess.Popen(['prometheus', f'--config.file={scratch}/prometheus.yaml', f'--storage.tsdb.path={scratch}/tsdb', f'--web.listen-address=127.0.0.1:{watcher}'], stderr=log)
    try:
        base, api = f'http://127.0.0.1:{port}', f'http://127.0.0.1:{watcher}/api/v1'
        query = lambda expr: asked(f'{api}/query?' + urllib.parse.urlencode({'query': expr}))['data']['result']
        soon(lambda: asked(base + '/readyz')); soon(lambda: query('up{job="sketchmatch"} == 1'))
        mesh = asked(base + '/v1/meshes?format=obj', ellipsoid(20, 16, 1.2).encode())
        sketch = asked(base + '/v1/sketches', json.dumps(outline(1.2)).encode(), {'Content-Type': 'application/json'})
        for _ in range(5):
            request = json.dumps({'mesh': mesh['id'], 'sketch': sketch['id']}).encode()
            asked(base + '/v1/matches', request, {'Content-Type': 'application/json', 'Prefer': 'wait=60'}); time.sleep(1)
        soon(lambda: query('sketchmatch_jobs_total{kind="match",outcome="succeeded"} >= 5'))
        with open(os.path.join(DEPLOY, 'grafana', 'dashboard.json')) as f: panels = json.load(f)['panels']
        empty = []
        for panel in panels:
            for target in panel['targets']:
                found = query(target['expr'].replace('$__rate_interval', '1m'))
                if not found: empty.append(panel['title'])
                print(f'{len(found):3} series: {panel["title"]}')
        found = [rule for group in soon(lambda: asked(f'{api}/rules')['data']['groups']) for rule in group['rules']]
        ill = [rule['name'] for rule in found if rule['health'] != 'ok']
        print(f'{len(found)} alerts evaluated, firing: {[rule["name"] for rule in found if rule["state"] == "firing"]}')
        if empty or ill: sys.exit(f'FAILED: nothing to show in {empty}; not evaluated {ill}')
    finally:
        for process in (server, prometheus): process.send_signal(signal.SIGTERM)
        for process in (server, prometheus): process.wait()
    shutil.rmtree(scratch)


if __name__ == '__main__': main()
