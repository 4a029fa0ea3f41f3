/** What the first visit costs: bytes, and the time until one can draw and until the mesh is there. */
import { open } from "../tests/drawing";
import { expect, test } from "../tests/server";

test("the first load", async ({ page }) => {
  await page.addInitScript(() => {
    const mark = (name: string, selector: string, isThere: (found: Element) => boolean) => {
      const watch = new MutationObserver(() => {
        const found = document.querySelector(selector);
        if (!found || !isThere(found)) return;
        performance.mark(name);
        watch.disconnect();
      });
      watch.observe(document, { subtree: true, childList: true, characterData: true });
    };
    mark("sheet", "svg.sheet", () => true);
    mark("mesh", ".chooser", ({ textContent }) => textContent?.includes("Cat") ?? false);
  });
  await open(page);
  const { bytes, sheet, mesh } = await page.evaluate(() => {
    const loads = [...performance.getEntriesByType("navigation"), ...performance.getEntriesByType("resource")];
    // What the page itself is made of; meshes and drawings come after it.
    const own = (loads as PerformanceResourceTiming[]).filter(({ name }) => !name.includes("/v1/"));
    const at = (name: string) => performance.getEntriesByName(name)[0]?.startTime ?? Number.NaN;
    return {
      bytes: own.reduce((sum, { transferSize }) => sum + transferSize, 0),
      sheet: at("sheet"),
      mesh: at("mesh"),
    };
  });
  console.log("\n| first load, kB | one can draw after, ms | the mesh is there after, ms |\n|---|---|---|");
  console.log(`| ${(bytes / 1000).toFixed(0)} | ${sheet.toFixed(0)} | ${mesh.toFixed(0)} |`);
  expect(bytes).toBeGreaterThan(0);
});
