.PHONY: run test bench bench-peer

# Serves on http://127.0.0.1:8080; the data is kept under ./data.
run:
	cargo run --release --locked -- serve

# Every check there is.
test:
	cargo fmt --check
	cargo clippy --locked --all-targets -- -D warnings
	cargo check --locked --lib --no-default-features
	cargo test --locked

# What every stage costs, as one table; see docs/performance.md. BENCH_ARGS: --sixty, --vast.
bench:
	cargo bench --locked --bench performance -- $(BENCH_ARGS)

# Times pyFM on the same meshes first, so that `make bench` prints ratios. Needs Python 3 and the network.
bench-peer:
	python3 -m venv target/bench-venv
	target/bench-venv/bin/pip install --quiet pyfmaps robust_laplacian potpourri3d trimesh threadpoolctl
	cargo bench --locked --bench performance -- --shapes
	target/bench-venv/bin/python benches/peer.py target/bench-data body50178.off
