"""A Prometheus that watches nodes at work, and is then asked for every panel of the dashboard and every alert.

Needs `prometheus` and `promtool` on the PATH.
"""
import json, os, shutil, subprocess, sys, time, urllib.parse, urllib.request

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


class Watch:
    """Scrapes these ports once a second, with the alerts of deploy/prometheus, each of which is made to fire first."""
    def __init__(self, ports, own, scratch):
        rules = os.path.join(DEPLOY, 'prometheus')
        for check in (['check', 'rules', 'alerts.yaml'], ['test', 'rules', 'alerts_test.yaml']):
            subprocess.run(['promtool', *check], cwd=rules, check=True, stdout=subprocess.DEVNULL)
        shutil.copy(os.path.join(rules, 'alerts.yaml'), scratch)
        with open(os.path.join(scratch, 'prometheus.yaml'), 'w') as f:
            json.dump({'global': {'scrape_interval': '1s', 'evaluation_interval': '1s'}, 'rule_files': ['alerts.yaml'],
                       'scrape_configs': [{'job_name': 'sketchmatch', 'static_configs': [{'targets': [f'127.0.0.1:{port}' for port in ports]}]}]}, f)
        self.api = f'http://127.0.0.1:{own}/api/v1'
        self.process = subprocess.Popen(['prometheus', f'--config.file={scratch}/prometheus.yaml', f'--storage.tsdb.path={scratch}/tsdb',
                                         f'--web.listen-address=127.0.0.1:{own}'], stderr=open(os.path.join(scratch, 'prometheus.log'), 'wb'))
        self.begun = time.time()
        soon(lambda: self.shown('up{job="sketchmatch"}'))

    def shown(self, expr):
        """The series of an expression since this Prometheus began, in a hundred places."""
        end = time.time()
        span = {'query': expr, 'start': self.begun, 'end': end, 'step': max(1, (end - self.begun) / 100)}
        return asked(f'{self.api}/query_range?' + urllib.parse.urlencode(span))['data']['result']

    def seen(self):
        """What came of it in words, and what is wrong: panels that have nothing to show, rules that could not be evaluated."""
        with open(os.path.join(DEPLOY, 'grafana', 'dashboard.json')) as f: panels = json.load(f)['panels']
        asked_for = [(panel['title'], target['expr'].replace('$__rate_interval', '1m')) for panel in panels for target in panel['targets']]
        empty = sorted({title for title, expr in asked_for if not self.shown(expr)})
        rules = [rule for group in asked(f'{self.api}/rules')['data']['groups'] for rule in group['rules']]
        ill = [rule['name'] for rule in rules if rule['health'] != 'ok']
        states = {state: [rule['name'] for rule in rules if rule['state'] == state] for state in ('pending', 'firing')}
        words = f'Prometheus: {len(panels)} panels, {len(rules)} alerts evaluated, {states["pending"]} pending, {states["firing"]} firing'
        return words, [f'nothing to show in {empty}'] * bool(empty) + [f'not evaluated: {ill}'] * bool(ill or not rules)

    def close(self): self.process.terminate(); self.process.wait()
