// Measures the ground in space while it turns; prints what it saw as one JSON object.
//
// node space.mjs PLAYWRIGHT CHROMIUM URL FRAMES FOLDER, where FOLDER gets the screenshots.

import { join } from "node:path";

import { open } from "./browser.mjs";

const [playwright, chromium, url, frames, folder] = process.argv.slice(2);
const { browser, page, seen, accessible } = await open(playwright, chromium, { viewport: { width: 1280, height: 800 } });

try {
  // The script of each frame in which the ground was drawn; whatever else the page shows anew is part of it.
  await page.addInitScript(() => {
    [window.scripts, window.drawings] = [[], 0];
    const { clear } = WebGL2RenderingContext.prototype;
    WebGL2RenderingContext.prototype.clear = function count(...words) {
      window.drawings += 1;
      return clear.apply(this, words);
    };
    const ask = window.requestAnimationFrame.bind(window);
    window.requestAnimationFrame = (callback) => ask((now) => {
      const [begun, drawings] = [performance.now(), window.drawings];
      callback(now);
      if (window.measures && window.drawings > drawings) window.scripts.push(performance.now() - begun);
    });
  });
  await page.goto(url);
  await page.waitForFunction(() => Number(document.getElementById("moment").max) >= 1);
  seen.hops = Number(await page.locator("#moment").getAttribute("max"));
  await page.waitForTimeout(2000);
  await page.screenshot({ path: join(folder, "large.png") });
  await accessible("large map");
  await page.keyboard.press("3");
  await page.waitForFunction(() => /calls/.test(document.getElementById("space-view").dataset.drawn ?? ""));
  await page.waitForTimeout(2000);
  const session = await page.context().newCDPSession(page);
  await session.send("Performance.enable", { timeDomain: "threadTicks" });
  const metrics = async () => Object.fromEntries((await session.send("Performance.getMetrics")).metrics.map(({ name, value }) => [name, value]));
  const before = await metrics();
  await page.evaluate(() => { window.measures = true; });
  const box = await page.locator("#space-view").boundingBox();
  const middle = [box.x + box.width / 2, box.y + box.height / 2];
  await page.mouse.move(...middle);
  await page.mouse.down();
  for (let n = 0; await page.evaluate(() => window.scripts.length) < Number(frames) && n < 20 * frames; n += 1) {
    await page.mouse.move(middle[0] + 200 * Math.sin(n / 10), middle[1] + 20 * Math.cos(n / 10));
  }
  await page.mouse.up();
  const scripts = await page.evaluate(() => { window.measures = false; return window.scripts; });
  const after = await metrics();
  scripts.sort((a, b) => a - b);
  const at = (share) => Number(scripts[Math.min(Math.floor(share * scripts.length), scripts.length - 1)].toFixed(2));
  seen.frames = scripts.length;
  seen.script_ms = { p50: at(0.5), p95: at(0.95), p99: at(0.99), max: at(1) };
  seen.thread_ms = Number(((1000 * (after.ScriptDuration - before.ScriptDuration)) / scripts.length).toFixed(2));
  seen.drawn = await page.locator("#space-view").getAttribute("data-drawn");
  await page.screenshot({ path: join(folder, "large-space.png") });
  await accessible("large map in space");
} catch (error) {
  seen.failure = error.stack;
}
await browser.close();
console.log(JSON.stringify(seen));
