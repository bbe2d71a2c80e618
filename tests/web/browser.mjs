// The browser of the page's tests: a page whose faults are collected.

import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";

const FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic", "--no-first-run", "--disable-background-networking",
  "--disable-component-update", "--disable-sync"];

/** Opens an empty page: the browser, the page, `seen` with the errors of its console and the violations of accessibility, and how to
 * wait for a drawing. */
export async function open(playwright, chromium, options) {
  const browsers = createRequire(join(playwright, "package.json"))("playwright-core");
  const browser = await browsers.chromium.launch({ executablePath: chromium, headless: true, args: FLAGS });
  const page = await browser.newPage(options);
  const seen = { errors: [], violations: [] };
  page.on("console", (message) => message.type() === "error" && seen.errors.push(message.text()));
  page.on("pageerror", (error) => seen.errors.push(error.message));
  page.setDefaultTimeout(120000);
  // Rules of accessibility; evaluated as the page's own policy lets no other script in.
  const axe = readFileSync(join(playwright, "../axe-core/axe.min.js"), "utf8");
  const accessible = async (state) => {
    await page.evaluate(axe);
    const { violations } = await page.evaluate(() => window.axe.run());
    seen.violations.push(...violations.map(({ id, nodes }) => `${state}: ${id} at ${nodes.map(({ target }) => target.join(" ")).join(", ")}`));
  };
  // Once the page has drawn what was asked of it: it draws once a frame, if anything has changed.
  const drawn = () => page.evaluate(() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))));
  return { browser, page, seen, accessible, drawn };
}
