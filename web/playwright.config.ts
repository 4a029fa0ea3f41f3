import { defineConfig } from "@playwright/test";

/** The tests of the page, against the program with the page built into it. */
export default defineConfig({
  testDir: "tests",
  // One server and one browser at a time: a match takes a processor.
  workers: 1,
  timeout: 180_000,
  expect: { timeout: 60_000 },
  reporter: "list",
  use: {
    viewport: { width: 1280, height: 860 },
    launchOptions: {
      executablePath: process.env.CHROMIUM ?? "/usr/bin/chromium",
      // WebGL without a graphics card, as browsers do it by themselves: to have all of the page drawn so takes twice as long.
      args: ["--no-sandbox", "--enable-unsafe-swiftshader"],
    },
  },
});
