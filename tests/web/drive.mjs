// Drives the monitor's page in a real browser; tells what it saw as one JSON object.
//
// node drive.mjs PLAYWRIGHT CHROMIUM URL FOLDER, where FOLDER gets the screenshots.

import { join } from "node:path";

import { open } from "./browser.mjs";

const [playwright, chromium, url, folder] = process.argv.slice(2);
const { browser, page, seen, accessible } = await open(playwright, chromium, { viewport: { width: 1440, height: 900 }, colorScheme: "dark" });
seen.elsewhere = [];
page.on("request", (request) => new URL(request.url()).origin !== new URL(url).origin && seen.elsewhere.push(request.url()));
// Every stream that the page opens is remembered.
await page.addInitScript(() => {
  window.streams = [];
  const Stream = window.EventSource;
  window.EventSource = class extends Stream {
    constructor(...words) {
      super(...words);
      window.streams.push(this);
    }
  };
});

const text = (selector) => page.locator(selector).innerText();
const shot = (name) => page.screenshot({ path: join(folder, `${name}.png`) });
const until = (claim, ...words) => page.waitForFunction(claim, words);
const hop = async () => Number(await page.locator("#moment").getAttribute("max"));

try {
  await page.goto(url);
  await until(() => document.getElementById("status").textContent === "under way");
  await until(() => Number(document.getElementById("moment").max) >= 2);
  seen.scenario = await text("#scenario");

  // Paused, nothing lands; a step is one landing.
  await page.click("#pause");
  await until(() => document.getElementById("status").textContent === "paused");
  seen.paused = await hop();
  await page.click("#step");
  await until(([before]) => Number(document.getElementById("moment").max) >= before + 1, seen.paused);
  await page.keyboard.press("s");
  await until(([before]) => Number(document.getElementById("moment").max) >= before + 2, seen.paused);
  seen.stepped = await hop();
  // A page that nobody sees lets go of its streams, and is whole again as soon as it is seen.
  const hide = (hidden) => page.evaluate((value) => {
    Object.defineProperty(document, "hidden", { value, configurable: true });
    document.dispatchEvent(new Event("visibilitychange"));
  }, hidden);
  const streams = () => page.evaluate(() => window.streams.filter((stream) => stream.readyState !== EventSource.CLOSED).length);
  seen.streams = [await streams()];
  await hide(true);
  await until(() => document.getElementById("status").textContent === "connecting");
  seen.streams.push(await streams());
  await hide(false);
  await until(([before]) => document.getElementById("status").textContent === "paused"
    && Number(document.getElementById("moment").max) === before, seen.stepped);
  seen.streams.push(await streams());

  // What the planner proves of its values stands beside it.
  await until(() => /^\d\.\de-\d+$/.test(document.querySelector("#leaders tbody td:nth-child(5)").textContent));
  seen.bound = await text("#leaders tbody td:nth-child(5)");
  await shot("paused");
  await accessible("dark");

  // Why this hop: four hops, of which the one taken is told first; a click asks about a cell, Escape goes back.
  await until(() => document.querySelectorAll("#why tbody tr.chosen td.value").length === 1 && document.querySelector("#why tbody tr.chosen td.value").textContent !== "–");
  seen.why = [await text("#why p"), await page.locator("#why tbody tr").count()];
  await page.locator("#map").click({ position: { x: 300, y: 300 } });
  await until(() => document.querySelector("#why h2").textContent.includes("Cell"));
  await shot("cell");
  await page.keyboard.press("Escape");
  await until(() => document.querySelector("#why h2").textContent.includes("This hop"));
  // Values with their ramp, then the same ground in space and back, by a key.
  await page.keyboard.press("v");
  await shot("values");
  await page.keyboard.press("v");
  await page.keyboard.press("3");
  await until(() => /calls/.test(document.getElementById("space-view").dataset.drawn ?? ""));
  await page.waitForTimeout(300);
  seen.space = await page.locator("#space-view").getAttribute("data-drawn");
  await shot("space");
  await page.keyboard.press("3");
  seen.flat = await page.locator("#space-view").isHidden();
  await page.keyboard.press("?");
  await page.keyboard.press("Escape");
  seen.help = await page.locator("#help").isVisible();

  // A stand-by is told to take over.
  seen.standby = await page.locator("#peers tbody tr", { has: page.locator("button") }).locator("td:nth-child(2)").innerText();
  await page.click("#peers button:not(:disabled)");
  await until(() => document.getElementById("answer").textContent.includes("takes command"));
  seen.answer = await text("#answer");
  await page.selectOption("#tempo", "20");
  await page.keyboard.press("k");
  await until(() => document.querySelectorAll("#leaders tbody tr").length === 2);
  seen.leaders = await page.locator("#leaders tbody tr td:nth-child(2)").allInnerTexts();
  await until(() => document.getElementById("events").textContent.includes("takes command"));
  await until(() => document.getElementById("why-note").textContent.startsWith("greedy"));
  seen.rule = await text("#why-note");
  await shot("swapped");

  // Back in time by keyboard, and to the present again.
  await until(() => Number(document.getElementById("moment").max) >= 11);
  await page.keyboard.press("Home");
  await until(() => document.getElementById("at").textContent.startsWith("hop 0 of"));
  await page.keyboard.press("Shift+ArrowRight");
  await page.keyboard.press("ArrowLeft");
  await until(() => document.getElementById("at").textContent.startsWith("hop 9 of"));
  await shot("back");
  await page.keyboard.press("End");

  await until(() => /over: |goal reached|deadlock|lost|left/.test(document.getElementById("status").textContent));
  await until(() => document.getElementById("events").textContent.includes("the mission is over"));
  seen.end = await text("#status");
  seen.hops = await hop();
  seen.leader = await text("#leader");
  // The page outlives the mission: a reload shows how it ended, and nobody who ended with it is silent.
  await page.reload();
  await until(([end]) => document.getElementById("status").textContent === end, seen.end.replace("over: ", ""));
  seen.reloaded = await text("#status");
  await until(() => document.querySelectorAll("#peers tbody tr").length > 0);
  seen.peers = [...new Set(await page.locator("#peers tbody tr td:nth-child(2)").allInnerTexts())];
  await page.keyboard.press("t");
  await page.setViewportSize({ width: 1280, height: 800 });
  await shot("goal-light");
  await accessible("light");
  // At this size events need no scrolling.
  seen.events = await page.evaluate(() => document.getElementById("events").getBoundingClientRect().bottom <= document.querySelector("footer").getBoundingClientRect().top);
  await page.keyboard.press("c");
  await page.setViewportSize({ width: 400, height: 860 });
  await page.waitForTimeout(100);
  seen.overflow = await page.evaluate(() => document.documentElement.scrollWidth - document.documentElement.clientWidth);
  await shot("narrow");
  await page.keyboard.press("c");
  await accessible("phone");
  // Fingers: nothing that can be pressed is smaller than 44 px, and the footer leaves the page its room.
  seen.small = await page.evaluate(() => [...document.querySelectorAll("button, select, input")]
    .filter((one) => one.offsetParent && Math.min(one.getBoundingClientRect().height, one.getBoundingClientRect().width) < 43.5).map((one) => one.id));
  seen.footer = await page.evaluate(() => document.querySelector("footer").getBoundingClientRect().height / window.innerHeight);
  // The map was drawn: its pixels are of many colours.
  seen.colours = await page.evaluate(() => {
    const canvas = document.getElementById("map");
    const { data } = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height);
    return new Set(new Uint32Array(data.buffer)).size;
  });
} catch (error) {
  seen.failure = `${error.message}; status ${await text("#status").catch(() => "?")}, hop ${await hop().catch(() => "?")}, answer ${await text("#answer").catch(() => "?")}`;
  await shot("failure").catch(() => {});
}
await browser.close();
console.log(JSON.stringify(seen));
