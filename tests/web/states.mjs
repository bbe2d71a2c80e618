// Looks at the page in its states, on desktops and phones; prints what it saw as one JSON object.
//
// node states.mjs PLAYWRIGHT CHROMIUM FOLDER NAME=URL..., where FOLDER gets the screenshots.

import { join } from "node:path";

import { open } from "./browser.mjs";

const [playwright, chromium, folder, ...missions] = process.argv.slice(2);
const urls = Object.fromEntries(missions.map((word) => word.split(/=(.*)/s).slice(0, 2)));
const [desktop, laptop, portrait, landscape] = [[1440, 900], [1280, 800], [390, 844], [844, 390]];

/** Each state: its mission, size of the window, theme and keys. */
const STATES = {
  light: ["hopper", laptop, "light"],
  dark: ["hopper", desktop, "dark"],
  portrait: ["expedition", portrait, "light"],
  landscape: ["expedition", landscape, "dark"],
  "space-one": ["hopper", laptop, "dark", "3"],
  "space-several": ["expedition", laptop, "light", "3"],
  "large-map": ["large", laptop, "dark"],
  coverage: ["coverage", laptop, "light"],
  "rover-helicopter": ["rover", laptop, "dark"],
  "hopper-helicopter": ["scout", laptop, "light"],
  expedition: ["expedition", laptop, "light"],
  interrupted: ["interrupted", laptop, "dark"],
};

const all = { failure: null, errors: [], violations: [], states: {} };

/** What of the page matters in any state. */
const facts = (page) => page.evaluate(() => {
  const texts = (selector) => [...document.querySelectorAll(selector)].filter((one) => one.offsetParent).map((one) => one.innerText.replace(/\s+/g, " ").trim());
  const box = (selector) => document.querySelector(selector).getBoundingClientRect();
  const canvas = document.querySelector(".ground canvas:not([hidden])").getBoundingClientRect();
  const isClipped = (one) => one.offsetParent && (one.getBoundingClientRect().right > window.innerWidth + 1 || one.getBoundingClientRect().left < -1);
  return {
    overflow: document.documentElement.scrollWidth - document.documentElement.clientWidth,
    clipped: [...document.querySelectorAll("header *, .over *, .ground canvas, .legend *, footer *")].filter(isClipped).map((one) => one.id || one.className || one.tagName),
    // How much of the map is above the timeline without scrolling, as a share of its height.
    map: (Math.min(canvas.bottom, box("footer").top) - canvas.top) / canvas.height,
    header: box("header").height,
    status: document.getElementById("status").textContent,
    clock: document.getElementById("clock").textContent,
    legend: texts(".legend span"),
    figures: texts("#figures div"),
    robots: texts("#robots tbody tr"),
    shapes: [...document.querySelectorAll("#robots .badge")].map((badge) => badge.className.replace("badge ", "")),
    why: [document.querySelector("#why p").innerText, document.querySelector("#why-note").innerText],
    rows: document.querySelectorAll("#why tbody tr").length,
    height: Math.round(box("#why").height),
    number: document.getElementById("why-number").textContent,
    text: document.body.innerText,
  };
});

try {
  for (const [state, [mission, [width, height], colorScheme, keys = ""]] of Object.entries(STATES)) {
    const isPhone = Math.min(width, height) < 480;
    const { browser, page, seen, accessible } = await open(playwright, chromium, { viewport: { width, height }, colorScheme, isMobile: isPhone, hasTouch: isPhone });
    await page.goto(urls[mission]);
    await page.waitForFunction(() => Number(document.getElementById("moment").max) >= 1 && document.getElementById("status").textContent !== "connecting");
    await page.waitForFunction(() => document.querySelector("#why p").innerText.length > 1 && !document.querySelector("#why .awaited"));
    for (const key of keys) await page.keyboard.press(key);
    if (keys.includes("3")) await page.waitForFunction(() => /calls/.test(document.getElementById("space-view").dataset.drawn ?? ""));
    await page.waitForTimeout(500);
    all.states[state] = await facts(page);
    await page.screenshot({ path: join(folder, `state-${state}.png`) });
    await accessible(state);
    if (state === "large-map") {
      // In space the panel follows too.
      await page.keyboard.press("3");
      await page.keyboard.press("Home");
      await page.keyboard.press("Shift+ArrowRight");
      await page.waitForFunction(() => document.getElementById("why-number").textContent === "hop 9");
      await page.waitForFunction(() => !document.querySelector("#why .awaited"));
      all.states["large-map-back"] = await facts(page);
      await page.screenshot({ path: join(folder, "state-large-map-back.png") });
    }
    all.errors.push(...seen.errors);
    all.violations.push(...seen.violations);
    await browser.close();
  }
} catch (error) {
  all.failure = error.stack;
}
console.log(JSON.stringify(all));
process.exit(0);
