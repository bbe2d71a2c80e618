// Looks at a past mission of several robots; prints what it saw as one JSON object.
//
// node team.mjs PLAYWRIGHT CHROMIUM URL FOLDER, where FOLDER gets the screenshots.

import { join } from "node:path";

import { open } from "./browser.mjs";

const [playwright, chromium, url, folder] = process.argv.slice(2);
const { browser, page, seen, accessible } = await open(playwright, chromium, { viewport: { width: 1280, height: 800 }, colorScheme: "light" });

try {
  await page.goto(url);
  await page.waitForFunction(() => document.querySelectorAll("#robots tbody tr").length > 0);
  await page.waitForFunction(() => Number(document.getElementById("moment").max) >= 100);
  await page.keyboard.press("Home");
  await page.keyboard.press("Shift+ArrowRight");
  await page.keyboard.press("End");
  await page.waitForTimeout(500);
  seen.robots = await page.locator("#robots tbody tr td:nth-child(4)").allInnerTexts();
  seen.badges = await page.evaluate(() => new Set([...document.querySelectorAll("#robots .badge")].map((badge) => badge.style.background)).size);
  seen.why = await page.locator("#why p").innerText();
  await page.screenshot({ path: join(folder, "team.png") });
  await accessible("several robots");
  await page.setViewportSize({ width: 400, height: 860 });
  await page.waitForTimeout(100);
  seen.overflow = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
} catch (error) {
  seen.failure = error.stack;
}
await browser.close();
console.log(JSON.stringify(seen));
