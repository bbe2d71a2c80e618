// Looks at a past mission whose hops are followed by physics, in 2D and in space; prints what it saw as one JSON object.
//
// node way.mjs PLAYWRIGHT CHROMIUM URL FOLDER NAME, where FOLDER gets the screenshots, whose names begin with NAME.

import { join } from "node:path";

import { open } from "./browser.mjs";

const [playwright, chromium, url, folder, name] = process.argv.slice(2);
const { browser, page, seen, accessible, drawn } = await open(playwright, chromium, { viewport: { width: 1440, height: 1100 }, colorScheme: "light" });
const shot = (what) => page.screenshot({ path: join(folder, `${name}-${what}.png`) });
const facts = () => page.locator("#why-way").evaluate((list) => (list.hidden ? null : Object.fromEntries([...list.children].map((row) => [row.firstChild.textContent, row.lastChild.textContent]))));

/** How many pixels of the map have a colour. */
const pixels = (rgb) => page.evaluate(([r, g, b]) => {
  const canvas = document.getElementById("map");
  const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
  let count = 0;
  for (let n = 0; n < data.length; n += 4) count += data[n] === r && data[n + 1] === g && data[n + 2] === b ? 1 : 0;
  return count;
}, rgb);

try {
  await page.goto(url);
  await page.waitForFunction(() => document.getElementById("status").textContent !== "connecting");
  await page.waitForFunction(() => Number(document.getElementById("moment").max) >= 3);
  seen.legend = await page.evaluate(() => [...document.querySelectorAll("[data-key=ways]")].map((key) => [key.innerText.trim(), !key.hidden]));
  // What the panel says of each of the first hops, and what the readout said while each was in flight.
  await page.evaluate(() => {
    window.readouts = [];
    new MutationObserver(() => window.readouts.push(document.getElementById("readout").textContent)).observe(document.getElementById("readout"), { childList: true, characterData: true, subtree: true });
  });
  await page.keyboard.press("Home");
  seen.hops = [];
  for (let hop = 0; hop < 3; hop += 1) {
    // A hop is shown in flight where the moment before has been on the page for a while.
    await drawn();
    await page.waitForTimeout(150);
    const before = await page.evaluate(() => window.readouts.length);
    await page.keyboard.press("ArrowRight");
    await page.waitForFunction(([number]) => document.getElementById("why-number").textContent === `hop ${number}`, [hop]);
    // Under the law no hop is in flight.
    if (name !== "law") await page.waitForFunction((before) => window.readouts.slice(before).some((text) => / of [\d.]+ s/.test(text)), before);
    seen.hops.push({ facts: await facts(), said: await page.locator("#why p").innerText() });
  }
  seen.readouts = await page.evaluate(() => window.readouts.filter((text) => / of [\d.]+ s/.test(text)));
  await shot("flight");
  await page.keyboard.press("End");
  // The last hop may still be in flight.
  await page.waitForFunction(() => !/ of [\d.]+ s/.test(document.getElementById("readout").textContent));
  await page.waitForTimeout(300);
  seen.rolled = await pixels([106, 47, 160]);
  await shot("map");
  await accessible("ways of hops");
  await page.keyboard.press("f");
  await page.waitForTimeout(300);
  await shot("near");
  await page.keyboard.press("f");
  await page.keyboard.press("3");
  await page.waitForFunction(() => /calls/.test(document.getElementById("space-view").dataset.drawn ?? ""));
  await page.waitForTimeout(500);
  seen.drawn = await page.locator("#space-view").getAttribute("data-drawn");
  await shot("space");
  await page.keyboard.press("f");
  await page.keyboard.press("+");
  await page.keyboard.press("+");
  await page.waitForTimeout(500);
  await shot("space-near");
  await page.keyboard.press("f");
  await page.keyboard.press("3");
  await page.setViewportSize({ width: 400, height: 860 });
  await page.waitForTimeout(100);
  seen.overflow = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
} catch (error) {
  seen.failure = error.stack;
}
await browser.close();
console.log(JSON.stringify(seen));
