.PHONY: run web test test-web test-page soak deployments context bench bench-peer

# Whether the page can be built here, by Node 20.19 or later, and looked at.
FITS := const [a, b] = process.versions.node.split("."); process.exit(a > 20 || (a == 20 && b >= 19) ? 0 : 1)
NODE := $(shell node -e '$(FITS)' 2> /dev/null && command -v npm)
CHROMIUM ?= $(shell command -v chromium || command -v chromium-browser || command -v google-chrome)
BROWSER := $(and $(NODE),$(CHROMIUM))

# How long the tests of the page may take in `make test`, in seconds: those that a busy machine does not come to are left out.
PAGE_SECONDS := 300

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

# Every check of the program, and those of its page where there are Node, Chromium and npm's registry.
test: test-built
	cargo fmt --check
	cargo clippy --locked --all-targets -- -D warnings
	cargo check --locked --lib --no-default-features
	cargo test --locked
	$(MAKE) context
	$(if $(BROWSER),if $(MAKE) -q web/dist/index.html; then $(MAKE) test-page; fi)

# Builds the page for its tests, before the program that embeds it, or says why they are left out.
.PHONY: test-built
test-built:
ifdef BROWSER
	$(MAKE) web || { ! npm ping && echo "The page is not tested here: npm's registry does not answer."; }
else
	@echo "The page is not tested here: that takes Node 20.19 or later and Chromium."
endif

# Lint, types, and the page in a real browser against the program: needs Node 20.19 or later and Chromium.
test-web: web
	$(MAKE) test-page PAGE_SECONDS=0

# The first test that fails ends it, so that what ran until the time was up has passed.
test-page:
	cd web && npm run check
	cargo build --locked
	cd web && SKETCHMATCH=../target/debug/sketchmatch CHROMIUM=$(CHROMIUM) \
		timeout --signal=INT --kill-after=30 $(PAGE_SECONDS) npx playwright test --max-failures=1 || \
		{ [ $$? = 124 ] && echo "$(PAGE_SECONDS) s were not enough for the tests of the page: see above which ran."; }

# What takes too long for every change: nodes killed, cut off and refused while they work, by PostgreSQL and an S3 server and by
# SQLite, and how fast 1, 2 and 4 are. Needs PostgreSQL with psql, Python 3 and the network. SOAK_ARGS: --jobs 200.
soak:
	cargo build --release --locked
	test -d target/soak-venv || python3 -m venv target/soak-venv
	target/soak-venv/bin/pip install --quiet 'moto[s3,server]'
	target/soak-venv/bin/python scripts/chaos.py --program target/release/sketchmatch $(SOAK_ARGS)
	target/soak-venv/bin/python scripts/chaos.py --program target/release/sketchmatch --sqlite $(SOAK_ARGS)
	target/soak-venv/bin/python scripts/tenants.py target/release/sketchmatch
	for nodes in 1 2 4; do \
		target/soak-venv/bin/python scripts/chaos.py --program target/release/sketchmatch --calm --nodes $$nodes $(SOAK_ARGS) || exit 1; \
	done

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
