import { defineConfig } from "vite";

/** The server that answers while the page is worked on. */
const SERVER = process.env.SKETCHMATCH_URL ?? "http://127.0.0.1:8080";

export default defineConfig({
  build: {
    target: "es2022",
    assetsInlineLimit: 0,
    modulePreload: { polyfill: false },
    license: { fileName: "licences.md" },
    chunkSizeWarningLimit: 700,
  },
  server: {
    proxy: Object.fromEntries(["/v1", "/docs", "/openapi.json", "/healthz"].map((path) => [path, SERVER])),
  },
});
