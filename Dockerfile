FROM rust:1.95-slim-bookworm AS build
WORKDIR /build

# The dependencies have a layer of their own: they take longest and change least.
COPY Cargo.toml Cargo.lock ./
RUN mkdir src \
    && touch src/lib.rs \
    && echo 'fn main() {}' > src/main.rs \
    && cargo build --release --locked \
    && rm -r src target/release/.fingerprint/sketchmatch-*

COPY migrations migrations
COPY src src
RUN cargo build --release --locked

FROM debian:bookworm-slim

RUN useradd --system --uid 10001 --no-create-home sketchmatch \
    && install --directory --owner=sketchmatch /data
COPY --from=build /build/target/release/sketchmatch /usr/local/bin/

USER 10001
VOLUME /data
EXPOSE 8080

# The image has no HTTP client; bash opens the connection itself.
HEALTHCHECK --interval=10s --timeout=5s --start-period=10s CMD ["bash", "-c", \
    "exec 3<>/dev/tcp/127.0.0.1/8080 && printf 'GET /readyz HTTP/1.0\\r\\n\\r\\n' >&3 && grep -q ' 200 OK' <&3"]

ENTRYPOINT ["sketchmatch"]
# Whoever publishes the port decides who reaches it: the server itself asks for no key.
CMD ["serve", "--listen", "0.0.0.0:8080", "--no-auth", "--data-dir", "/data"]
