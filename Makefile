.PHONY: run test

# Serves on http://127.0.0.1:8080; the data is kept under ./data.
run:
	cargo run --release --locked -- serve

# Every check there is.
test:
	cargo fmt --check
	cargo clippy --locked --all-targets -- -D warnings
	cargo check --locked --lib --no-default-features
	cargo test --locked
