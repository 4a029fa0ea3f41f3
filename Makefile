.PHONY: run web test test-web soak traces deployments context bench bench-peer

# Whether the page can be built here, by Node 20.19 or later, and looked at.
FITS := const [a, b] = process.versions.node.split("."); process.exit(a > 20 || (a == 20 && b >= 19) ? 0 : 1)
NODE := $(shell node -e '$(FITS)' 2> /dev/null && command -v npm)
CHROMIUM ?= $(shell command -v chromium || command -v chromium-browser || command -v google-chrome)

# Serves on http://127.0.0.1:8080; the data is kept under ./data.
run: $(if $(NODE),web,no-web)
	cargo run --release --locked -- serve

# Builds the page into web/dist, which the program embeds: cargo looks there again once the file that embeds it is newer.
web: web/dist/index.html

web/dist/index.html: openapi/openapi.json $(shell find web/src web/*.* -type f ! -name schema.d.ts)
	cd web && npm ci --no-audit --no-fund && npm run build
	touch $@ src/http/front_page.rs

.PHONY: no-web
no-web:
	@echo "There is no Node here: the service runs without its page (Node 20.19 or later builds it)."

# Every check: of the program, and of its page where there are Node and Chromium.
test:
	cargo fmt --check
	cargo clippy --locked --all-targets -- -D warnings
	cargo check --locked --lib --no-default-features
	cargo test --locked
	$(MAKE) context
	$(if $(and $(NODE),$(CHROMIUM)),$(MAKE) test-web,@echo "The page was not tested: test-web needs Node 20.19 or later and Chromium.")

# Lint, types, and the page in a real browser against the program: needs Node 20.19 or later and Chromium.
test-web: web
	cd web && npm run check
	cargo build --locked
	cd web && SKETCHMATCH=$(abspath $(or $(CARGO_TARGET_DIR),target))/debug/sketchmatch CHROMIUM=$(CHROMIUM) npm test

# What takes too long for every change: nodes killed, cut off and refused while they work, by PostgreSQL and an S3 server and by
# SQLite, watched by a Prometheus; one asked for ten times what it can do; and how fast 1, 2 and 4 are. Needs PostgreSQL with psql,
# Prometheus with promtool, Python 3 and the network. SOAK_ARGS: --jobs 200.
soak:
	cargo build --release --locked
	test -d target/soak-venv || python3 -m venv target/soak-venv
	target/soak-venv/bin/pip install --quiet 'moto[s3,server]'
	target/soak-venv/bin/python scripts/chaos.py --program target/release/sketchmatch --watched $(SOAK_ARGS)
	target/soak-venv/bin/python scripts/chaos.py --program target/release/sketchmatch --sqlite $(SOAK_ARGS)
	target/soak-venv/bin/python scripts/overload.py target/release/sketchmatch
	target/soak-venv/bin/python scripts/tenants.py target/release/sketchmatch
	for nodes in 1 2 4; do \
		target/soak-venv/bin/python scripts/chaos.py --program target/release/sketchmatch --calm --nodes $$nodes $(SOAK_ARGS) || exit 1; \
	done

# One match as a collector of OpenTelemetry has it, from the request to the store. Needs Python 3 and the network.
traces:
	cargo build --locked --features otel
	test -d target/traces-venv || python3 -m venv target/traces-venv
	target/traces-venv/bin/pip install --quiet opentelemetry-proto
	target/traces-venv/bin/python scripts/traces.py target/debug/sketchmatch

# What is in deploy/, by schemas. Needs Python 3 and the network.
deployments:
	test -d target/deploy-venv || python3 -m venv target/deploy-venv
	target/deploy-venv/bin/pip install --quiet kubernetes-validate check-jsonschema pyyaml
	PATH=$(CURDIR)/target/deploy-venv/bin:$$PATH python3 scripts/deployments.py

# The image is built from what .dockerignore admits: so much has to compile.
context:
	rm -rf target/context
	mkdir -p target/context
	tar -cf - $$(sed -n 's/^!//p' .dockerignore) | tar -xf - -C target/context
	cargo check --locked --bin sketchmatch --manifest-path target/context/Cargo.toml --target-dir target

# What every stage costs, as one table; see docs/performance.md. BENCH_ARGS: --sixty, --vast, --stretches.
bench:
	cargo bench --locked --bench performance -- $(BENCH_ARGS)

# Times pyFM on the same meshes first, so that `make bench` prints ratios. Needs Python 3 and the network.
bench-peer:
	python3 -m venv target/bench-venv
	target/bench-venv/bin/pip install --quiet pyfmaps robust_laplacian potpourri3d trimesh threadpoolctl
	cargo bench --locked --bench performance -- --shapes
	target/bench-venv/bin/python benches/peer.py target/bench-data body50178.off
