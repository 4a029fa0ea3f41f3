/** The program, serving a directory of its own on a free port, and a page open on it. */
import { type ChildProcess, spawn } from "node:child_process";
import { mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { createInterface } from "node:readline";
import { test as base, expect } from "@playwright/test";

const PROGRAM = process.env.SKETCHMATCH ?? "../target/release/sketchmatch";

export class Server {
  private child: ChildProcess | null = null;
  private readonly data = mkdtempSync(join(tmpdir(), "sketchmatch-page-"));
  /** Host and port, kept over a restart. */
  private authority = "127.0.0.1:0";

  /** Starts it, with these options beside its own. */
  async start(...others: string[]) {
    const own = ["serve", "--listen", this.authority, "--data-dir", this.data, "--log-format", "json"];
    const options = [...own, ...others];
    this.child = spawn(PROGRAM, options, { stdio: ["ignore", "ignore", "pipe"] });
    const lines = createInterface({ input: this.child.stderr as NodeJS.ReadableStream });
    this.authority = await new Promise((resolve, reject) => {
      lines.on("line", (line) => {
        const { address } = JSON.parse(line);
        if (address) resolve(address);
      });
      this.child?.on("exit", () => reject(new Error("the server ended before it told its address")));
      this.child?.on("error", reject);
    });
  }

  async stop() {
    const child = this.child;
    if (!child || child.exitCode !== null) return;
    const ended = new Promise((resolve) => child.on("exit", resolve));
    child.kill("SIGTERM");
    await ended;
  }

  async close() {
    await this.stop();
    rmSync(this.data, { recursive: true, force: true });
  }

  /** The path of a file that is deleted with the server's own. */
  file(name: string) {
    return join(this.data, name);
  }

  get url() {
    return `http://${this.authority}`;
  }
}

interface Fixtures {
  /** What the page said to the console that it should not have, among it breaches of the content security policy. */
  complaints: string[];
}

export const test = base.extend<Fixtures, { server: Server }>({
  server: [
    // biome-ignore lint/correctness/noEmptyPattern: Playwright reads the names of fixtures from it.
    async ({}, use) => {
      const server = new Server();
      await server.start();
      await use(server);
      await server.close();
    },
    { scope: "worker" },
  ],
  baseURL: async ({ server }, use) => use(server.url),
  complaints: async ({ page }, use) => {
    const complaints: string[] = [];
    page.on("pageerror", (error) => complaints.push(String(error)));
    page.on("console", (message) => {
      // A refusal by the server is told by the browser too: the page is to say it, not to avoid it.
      const isRefusal = message.text().startsWith("Failed to load resource");
      if (message.type() === "error" && !isRefusal) complaints.push(message.text());
    });
    page.on("request", (request) => {
      const { protocol, origin } = new URL(request.url());
      const isOwn = protocol === "blob:" || origin === new URL(page.url()).origin || page.url() === "about:blank";
      if (!isOwn) complaints.push(`asked another host: ${request.url()}`);
    });
    await use(complaints);
    expect(complaints).toEqual([]);
  },
});

export { expect };
