FROM node:22-bookworm-slim AS page
WORKDIR /build/web
COPY web/package.json web/package-lock.json web/.npmrc ./
RUN --mount=type=cache,target=/root/.npm npm ci --no-audit --no-fund
COPY openapi ../openapi
COPY web .
RUN npm run build

FROM rust:1.95-slim-bookworm AS build
WORKDIR /build
COPY . .
COPY --from=page /build/web/dist web/dist
# Crates and what was compiled outlive the build in the builder's cache: after a change only the sources are compiled.
RUN --mount=type=cache,target=/usr/local/cargo/registry --mount=type=cache,target=/build/target \
    cargo build --release --locked \
    && install -D target/release/sketchmatch /image/usr/local/bin/sketchmatch \
    && mkdir /image/data

# The C library and little else: no shell, no package manager.
FROM gcr.io/distroless/cc-debian12:nonroot

COPY --from=build /image/usr /usr
COPY --from=build --chown=65532:65532 /image/data /data

USER 65532:65532
ENV SKETCHMATCH_DATA_DIR=/data
VOLUME /data
EXPOSE 8080
STOPSIGNAL SIGTERM
HEALTHCHECK --interval=10s --timeout=5s --start-period=10s CMD ["sketchmatch", "health"]

ENTRYPOINT ["sketchmatch"]
# It starts once there is a key: `keys add` with the same volume makes one.
CMD ["serve", "--listen", "0.0.0.0:8080"]
