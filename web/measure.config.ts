import config from "./playwright.config";

/** How long it takes from the pen lifted to the colours on the mesh: `npm run measure`. */
export default { ...config, testDir: "measure", timeout: 600_000 };
