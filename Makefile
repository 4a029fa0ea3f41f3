.PHONY: run test context bench bench-peer

# Serves on http://127.0.0.1:8080; the data is kept under ./data.
run:
	cargo run --release --locked -- serve

# Every check there is.
test:
	cargo fmt --check
	cargo clippy --locked --all-targets -- -D warnings
	cargo check --locked --lib --no-default-features
	cargo test --locked
	$(MAKE) context

# The image is built from what .dockerignore admits: so much has to compile.
context:
	rm -rf target/context
	mkdir -p target/context
	cp -R $$(sed -n 's/^!//p' .dockerignore) target/context
	cargo check --locked --bin sketchmatch --manifest-path target/context/Cargo.toml --target-dir target

# What every stage costs, as one table; see docs/performance.md. BENCH_ARGS: --sixty, --vast.
bench:
	cargo bench --locked --bench performance -- $(BENCH_ARGS)

# Times pyFM on the same meshes first, so that `make bench` prints ratios. Needs Python 3 and the network.
bench-peer:
	python3 -m venv target/bench-venv
	target/bench-venv/bin/pip install --quiet pyfmaps robust_laplacian potpourri3d trimesh threadpoolctl
	cargo bench --locked --bench performance -- --shapes
	target/bench-venv/bin/python benches/peer.py target/bench-data body50178.off
