#!/usr/bin/env python3
"""Collects the spans of one match from a server built with the feature `otel`, and prints them as the tree they are.

    cargo build --locked --features otel && python3 scripts/traces.py target/debug/sketchmatch

It fails unless request, job, computation and store are parts of the trace the client began. Needs the Python package
`opentelemetry-proto`.
"""
import collections, http.server, json, os, shutil, signal, subprocess, sys, tempfile, threading
sys.path.insert(0, os.path.dirname(__file__))
from chaos import ellipsoid, free_port, outline
from watching import asked, soon
from opentelemetry.proto.collector.trace.v1.trace_service_pb2 import ExportTraceServiceRequest

TRACE, PARENT = '4bf92f3577b34da6a3ce929d0e0e4736', '00f067aa0ba902b7'
spans = []


class Collector(http.server.BaseHTTPRequestHandler):
    def do_POST(self):
        request = ExportTraceServiceRequest.FromString(self.rfile.read(int(self.headers['content-length'])))
        spans.extend(span for resource in request.resource_spans for scope in resource.scope_spans for span in scope.spans)
        self.send_response(200); self.send_header('content-length', '0'); self.end_headers()

    def log_message(self, *_): pass


def main():
    scratch, port = tempfile.mkdtemp(prefix='sketchmatch-traces-'), free_port()
    collector = http.server.ThreadingHTTPServer(('127.0.0.1', 0), Collector)
    threading.Thread(target=collector.serve_forever, daemon=True).start()
    environment = {**os.environ, 'OTEL_EXPORTER_OTLP_ENDPOINT': f'http://127.0.0.1:{collector.server_port}'}
    log = open(os.path.join(scratch, 'log'), 'wb')
    server = subprocess.Popen([sys.argv[1], 'serve', '--listen', f'127.0.0.1:{port}', '--data-dir', scratch + '/data'], env=environment, stderr=log)
    try:
        base = f'http://127.0.0.1:{port}'
        soon(lambda: asked(base + '/readyz'))
        mesh = asked(base + '/v1/meshes?format=obj', ellipsoid(20, 16, 1.2).encode())
        sketch = asked(base + '/v1/sketches', json.dumps(outline(1.2)).encode(), {'Content-Type': 'application/json'})
        request = json.dumps({'mesh': mesh['id'], 'sketch': sketch['id']}).encode()
        asked(base + '/v1/matches', request, {'Content-Type': 'application/json', 'Prefer': 'wait=60', 'traceparent': f'00-{TRACE}-{PARENT}-01'})
    finally:
        # What waits is sent at the end.
        server.send_signal(signal.SIGTERM); server.wait()
    ours = [span for span in spans if span.trace_id.hex() == TRACE]
    below = collections.defaultdict(list)
    for span in sorted(ours, key=lambda span: span.start_time_unix_nano): below[span.parent_span_id.hex()].append(span)
    begun = min((span.start_time_unix_nano for span in ours), default=0)
    told = {'operation', 'path', 'kind', 'waited_ms'}
    def show(parent, depth):
        for span in below[parent]:
            values = ' '.join(f'{a.key}={a.value.string_value or a.value.int_value}' for a in span.attributes if a.key in told)
            start, end = ((t - begun) / 1e6 for t in (span.start_time_unix_nano, span.end_time_unix_nano))
            print(f'{start:8.1f} to {end:8.1f} ms  {"  " * depth}{span.name} {values}')
            show(span.span_id.hex(), depth + 1)
    show(PARENT, 0)
    missing = {'request', 'job', 'computing', 'store'} - {span.name for span in ours}
    if missing: sys.exit(f'FAILED: no {missing} in the trace; log in {scratch}')
    shutil.rmtree(scratch)


if __name__ == '__main__': main()
