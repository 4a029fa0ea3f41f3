#!/bin/sh
# Generates clients in TypeScript, Python and Rust from the OpenAPI document of a running server, compiles them, and has
# each match an example creature: upload, match, events, result, picture. Fails at the first value that is wrong.
#
#     scripts/generated_clients.sh http://127.0.0.1:8080
#
# Needs curl, Python 3, node and cargo, and their package registries. Works in target/generated-clients.
set -eu

server=${1:?the address of a running server}
clients=$(cd "$(dirname "$0")/generated_clients" && pwd)
work=$(dirname "$clients")/../target/generated-clients
mkdir -p "$work"
cd "$work"

curl -fsS "$server/openapi.json" > openapi.json
curl -fsS "$server/v1/examples/quadruped/mesh" > mesh.obj
curl -fsS "$server/v1/examples/quadruped/sketch" > sketch.json

[ -x python/bin/pip ] || python3 -m venv python
python/bin/pip install --quiet 'openapi-spec-validator==0.9.*' 'openapi-python-client==0.29.*'
python/bin/openapi-spec-validator openapi.json

echo 'Python: openapi-python-client'
python/bin/openapi-python-client generate --path openapi.json --output-path sketchmatch_client --meta none --overwrite \
    > python.log 2>&1
if grep -E 'WARNING|Unable' python.log; then exit 1; fi
python/bin/python "$clients/walk.py" "$server"

echo 'TypeScript: openapi-typescript and openapi-fetch'
mkdir -p typescript
cp "$clients/walk.ts" "$clients/package.json" typescript/
(
    cd typescript
    npm install --silent --no-audit --no-fund
    npx openapi-typescript ../openapi.json --output api.d.ts
    npx tsc --strict --target es2023 --module nodenext --skipLibCheck walk.ts
    node walk.js "$server" ../mesh.obj ../sketch.json
)

echo 'Rust: oas3-gen'
cargo install --quiet --locked --root tools oas3-gen@0.29.0
mkdir -p rust/src
cp "$clients/rust/Cargo.toml" rust/
cp "$clients/rust/src/main.rs" rust/src/
tools/bin/oas3-gen generate client-mod --quiet --workspace --input openapi.json --output rust/sketchmatch_client
# The derive of `validator` cannot look into a field that is called `errors`.
sed -i '/validate(nested)/{N;/pub errors:/s/.*\n//}' rust/sketchmatch_client/src/types.rs
cargo run --quiet --manifest-path rust/Cargo.toml -- "$server" mesh.obj sketch.json
