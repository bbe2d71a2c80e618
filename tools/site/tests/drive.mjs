// Drives the page without a server in a real browser; tells what it saw as one JSON object.
//
// node drive.mjs PLAYWRIGHT CHROMIUM SITE FOLDER, with outcomes to compare on standard input: FOLDER has an elevation model
// `model.asc` and gets the screenshots.

import { createServer } from "node:http";
import { readFileSync } from "node:fs";
import { createRequire } from "node:module";
import { extname, join, normalize } from "node:path";

const [playwright, chromium, site, folder] = process.argv.slice(2);
const missions = readFileSync(0, "utf8").split("\n").filter(Boolean);
const browsers = createRequire(join(playwright, "package.json"))("playwright-core");
const FLAGS = ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-quic", "--no-first-run", "--disable-background-networking",
  "--disable-component-update", "--disable-sync"];

// Any server of static files, below a path of its own.
const TYPES = { ".html": "text/html", ".js": "text/javascript", ".css": "text/css", ".svg": "image/svg+xml" };
const server = createServer(({ url }, answer) => {
  const path = normalize(new URL(url, "http://any").pathname).replace(/^\/hopper\//, "/").replace(/\/$/, "/index.html");
  try {
    const contents = readFileSync(join(site, path));
    answer.writeHead(200, { "Content-Type": TYPES[extname(path)] ?? "application/octet-stream" }).end(contents);
  } catch {
    answer.writeHead(404).end();
  }
});
await new Promise((done) => server.listen(0, "127.0.0.1", done));
const home = `http://127.0.0.1:${server.address().port}/hopper/`;

const browser = await browsers.chromium.launch({ executablePath: chromium, headless: true, args: FLAGS, timeout: 180000 });
const page = await browser.newPage({ viewport: { width: 1440, height: 900 }, colorScheme: "dark" });
const seen = { errors: [], elsewhere: [], violations: [] };
page.on("console", (message) => message.type() === "error" && seen.errors.push(message.text()));
page.on("pageerror", (error) => seen.errors.push(error.message));
page.on("request", (request) => !request.url().startsWith(home) && seen.elsewhere.push(request.url()));
page.setDefaultTimeout(120000);
const axe = readFileSync(join(playwright, "../axe-core/axe.min.js"), "utf8");
const text = (selector) => page.locator(selector).innerText();
// For whoever looks at them; a slow machine may have none.
const shot = (name) => page.screenshot({ path: join(folder, `${name}.png`), timeout: 30000 }).catch(() => {});
const until = (claim, ...words) => page.waitForFunction(claim, words);
const status = (wanted) => until(([wanted]) => document.getElementById("status").textContent === wanted, wanted);
const shown = async () => Number(await page.locator("#moment").inputValue());

try {
  // The link says all: the mission waits at its hop, whose planner took over before.
  await page.goto(`${home}#scenario=hard&profile=paper-2023&seed=3&planner=mdp,greedy@4&hop=6`);
  await status("paused");
  await until(() => document.querySelectorAll("#leaders tbody tr").length === 2);
  seen.linked = { scenario: await text("#scenario"), profile: await text("#profile"), hop: await shown(), leaders: await page.locator("#leaders tbody td:nth-child(2)").allInnerTexts(), from: await page.locator("#leaders tbody td:nth-child(3)").allInnerTexts() };
  await until(() => document.querySelectorAll("#why tbody tr").length === 4 && /\d/.test(document.querySelector("#why tbody td").textContent));
  await shot("linked");
  await page.evaluate(axe);
  seen.violations = (await page.evaluate(() => window.axe.run())).violations.map(({ id, nodes }) => `${id} at ${nodes.map(({ target }) => target.join(" ")).join(", ")}`);

  // A click swaps the planner; orders are obeyed; the link tells of it.
  await page.selectOption("#choice [name=planner]", "astar");
  await page.selectOption("#tempo", "20");
  await page.click("#pause");
  await until(() => document.getElementById("leader").textContent.startsWith("astar"));
  await page.keyboard.press("End");
  await until(() => /goal reached|deadlock|lost|left|steps|over/.test(document.getElementById("status").textContent));
  seen.end = await text("#status");
  seen.peers = [...new Set(await page.locator("#peers tbody tr td:nth-child(2)").allInnerTexts())];
  await page.getByRole("button", { name: "Link" }).click();
  await until(() => location.hash.includes("astar@"));
  seen.link = new URL(page.url()).hash;
  const hops = await page.locator("#moment").getAttribute("max");
  // What the link says, opened elsewhere, is what was flown.
  const again = await browser.newPage();
  await again.goto(page.url());
  await again.waitForFunction(([hops]) => document.getElementById("moment").max === hops && document.getElementById("status").textContent !== "under way", [hops]);
  seen.again = await again.locator("#status").innerText();
  seen.hops = [hops, await again.locator("#moment").getAttribute("max")];
  await again.close();

  // Another scenario by a choice.
  await page.selectOption("#choice [name=scenario]", "sandy");
  await until(() => document.getElementById("scenario").textContent === "sandy" && Number(document.getElementById("moment").max) >= 2);
  // Its planner stays the one of before, and has no policy; another has, also where the mission is over by now.
  await page.selectOption("#choice [name=planner]", "mdp");
  await until(() => /^policy of mdp/.test(document.getElementById("policy-note").textContent));
  await shot("chosen");

  // An elevation model dropped on the page becomes the ground.
  const model = readFileSync(join(folder, "model.asc"), "utf8");
  const dropped = await page.evaluateHandle((model) => {
    const data = new DataTransfer();
    data.items.add(new File([model], "model.asc"));
    return data;
  }, model);
  await page.dispatchEvent("body", "drop", { dataTransfer: dropped });
  await until(() => document.getElementById("scenario").textContent === "model" && Number(document.getElementById("moment").max) >= 2);
  seen.dropped = await text("#asked");
  await shot("dropped");

  // The module itself, in this browser.
  seen.outcomes = await page.evaluate(async (missions) => {
    const { load } = await import("./module.js");
    const call = await load(await fetch("./hopper.wasm"));
    return missions.map((mission) => call("fly", mission));
  }, missions);
} catch (error) {
  seen.failure = `${error.message}; status ${await text("#status").catch(() => "?")}, asked ${await text("#asked").catch(() => "?")}`;
  await shot("failure");
}
await browser.close();
server.close();
console.log(JSON.stringify(seen));
