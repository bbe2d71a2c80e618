// Measures how smoothly the monitor's page runs in a real browser; tells it as one JSON object, in milliseconds.
//
// node frames.mjs PLAYWRIGHT CHROMIUM URL SECONDS [SCREENSHOT [KEYS]], where KEYS are pressed before it is measured, e.g. p for the policy

import { createRequire } from "node:module";
import { join } from "node:path";

const [playwright, chromium, url, seconds, picture, keys] = process.argv.slice(2);
const browsers = createRequire(join(playwright, "package.json"))("playwright-core");
const FLAGS = ["--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
  "--disable-component-update", "--disable-sync"];

const browser = await browsers.chromium.launch({ executablePath: chromium, headless: true, args: FLAGS });
const page = await browser.newPage({ viewport: { width: 1440, height: 900 }, colorScheme: "dark" });
const errors = [];
page.on("pageerror", (error) => errors.push(error.message));
// Whatever the page does for a frame is timed around its callback.
await page.addInitScript(() => {
  window.timed = [];
  const ask = window.requestAnimationFrame.bind(window);
  window.requestAnimationFrame = (draw) => ask((at) => {
    const began = performance.now();
    draw(at);
    window.timed.push([at, performance.now() - began]);
  });
});
await page.goto(url);
await page.waitForFunction(() => Number(document.getElementById("moment").max) >= 5, null, { timeout: 120000 });
for (const pressed of keys ?? "") await page.keyboard.press(pressed);
await page.waitForTimeout(2000);
const due = () => page.evaluate(() => Number(document.getElementById("moment").max));
const before = await due();
await page.evaluate(() => { window.timed = []; });
await page.waitForTimeout(1e3 * Number(seconds));
const timed = await page.evaluate(() => window.timed);
const hops = (await due()) - before;
if (picture) await page.screenshot({ path: picture });
await browser.close();

const spread = (values) => {
  const sorted = [...values].sort((a, b) => a - b);
  const quantile = (share) => Number((sorted[Math.min(Math.ceil(share * sorted.length), sorted.length) - 1] ?? 0).toFixed(2));
  return { p50: quantile(0.5), p99: quantile(0.99), max: quantile(1) };
};
const between = timed.slice(1).map(([at], n) => at - timed[n][0]);
console.log(JSON.stringify({
  seconds: Number(seconds), hops, frames: timed.length, between: spread(between), script: spread(timed.map(([, ms]) => ms)),
  later_than_50_ms: between.filter((ms) => ms > 50).length, errors,
}));
