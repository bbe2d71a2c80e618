// Looks at a mission over uncertain ground; prints what it saw as one JSON object.
//
// node layers.mjs PLAYWRIGHT CHROMIUM URL FOLDER NAME, where FOLDER gets the screenshots, named after NAME.

import { join } from "node:path";

import { open } from "./browser.mjs";

const [playwright, chromium, url, folder, name] = process.argv.slice(2);
const { browser, page, seen, accessible, drawn } = await open(playwright, chromium, { viewport: { width: 1280, height: 800 }, colorScheme: "light" });

/** Where a place in metres from the south-western corner is on the page, and the colour there. */
const look = ([x, y]) => page.evaluate(([mx, my]) => {
  const canvas = document.getElementById("map");
  const { clientWidth: width, clientHeight: height } = canvas;
  // The whole map in its frame: 44 pixels to its left, 22 below, 10 elsewhere; 200 m each way.
  const scale = Math.min(width - 54, height - 32) / 200;
  const [left, top] = [44 + (width - 54) / 2 - 100 * scale, 10 + (height - 32) / 2 - 100 * scale];
  const [px, py] = [left + mx * scale, top + (200 - my) * scale];
  const ratio = window.devicePixelRatio;
  return [...canvas.getContext("2d").getImageData(Math.round(px * ratio), Math.round(py * ratio), 1, 1).data.slice(0, 3)];
}, [x, y]);

/** The colours of a few places that no line crosses: discs, open ground. */
const places = async () => Promise.all([[100, 62.5], [100, 137.5], [30, 30], [185, 185]].map(look));

/** Once all of a mission that is over is on the page: nothing has come for a second. */
const settled = async () => {
  const told = () => page.evaluate(() => document.getElementById("moment").max + document.getElementById("figures").innerText);
  for (let [before, still] = [await told(), 0]; still < 4;) {
    await page.waitForTimeout(250);
    const now = await told();
    still = now === before ? still + 1 : 0;
    before = now;
  }
};

try {
  await page.goto(url);
  await page.waitForFunction(() => Number(document.getElementById("moment").max) >= 20);
  await page.waitForFunction(() => document.querySelectorAll("#robots tbody tr").length === 2);
  await page.waitForFunction(() => !document.querySelector("[data-key=routes]").hidden);
  await settled();
  seen.layers = await page.locator("#layer option").allInnerTexts();
  const figure = (name) => page.locator("#figures div", { hasText: name }).locator("dd").innerText();
  seen.share = (await figure("seen")).replace(/\s+/g, " ");
  seen.first = await page.locator("#layer").inputValue();
  seen.legends = {};
  seen.colours = {};
  for (let n = 0; n < 4; n += 1) {
    const layer = await page.locator("#layer").inputValue();
    seen.legends[layer] = (await page.locator(".legend .ramp").first().innerText()).replace(/\s+/g, " ");
    seen.colours[layer] = await places();
    await page.screenshot({ path: join(folder, `${name}-${layer}.png`) });
    await accessible(layer);
    await page.keyboard.press("m");
    await drawn();
  }
  seen.around = await page.locator("#layer").inputValue();
  // By the control itself, without a mouse.
  await page.locator("#layer").focus();
  await page.keyboard.press("ArrowDown");
  await drawn();
  seen.chosen = await page.locator("#layer").inputValue();
  await page.locator("#layer").selectOption("speed");
  await page.locator("#map").focus();
  await page.keyboard.press("Home");
  await drawn();
  seen.before = await places();
  await page.screenshot({ path: join(folder, `${name}-before.png`) });
  const at = await page.locator("#map").boundingBox();
  await page.mouse.move(at.x + at.width / 2, at.y + at.height / 2);
  await drawn();
  seen.readout = await page.locator("#readout").innerText();
  await page.keyboard.press("3");
  await page.waitForTimeout(500);
  await page.screenshot({ path: join(folder, `${name}-space.png`) });
  await page.keyboard.press("3");
  await page.setViewportSize({ width: 400, height: 860 });
  await drawn();
  seen.overflow = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
} catch (error) {
  seen.failure = error.stack;
}
await browser.close();
console.log(JSON.stringify(seen));
