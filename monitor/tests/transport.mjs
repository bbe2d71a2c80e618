// Checks what the page does with the key of orders and with its place among the streams; exits with an error if something is wrong.
//
// node transport.mjs TRANSPORT, where TRANSPORT is the page's module.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";

const text = await readFile(process.argv[2], "utf8");
let pages = 0;

/** The module in a tab at an address with `hash`, with what the tab has kept; `answer` is the server's to an order. */
async function open(hash, kept, answer = { ok: true, status: 202 }) {
  pages += 1;
  const tab = { asked: [], streams: [], kept };
  globalThis.location = { hash, pathname: "/" };
  globalThis.history = { replaceState: () => {} };
  globalThis.sessionStorage = {
    getItem: (name) => kept.get(name) ?? null, setItem: (name, value) => kept.set(name, value), removeItem: (name) => kept.delete(name),
  };
  globalThis.EventSource = class extends EventTarget {
    constructor(url) {
      super();
      tab.streams.push([url, this]);
    }
  };
  globalThis.fetch = async (url, request) => {
    tab.asked.push(request ? [url, request.headers["X-Hopper-Key"]] : [url]);
    return { ...answer, text: async () => "why not\n" };
  };
  tab.module = await import(`data:text/javascript,${encodeURIComponent(`${text}\n// page ${pages}`)}`);
  return tab;
}

/** The first event of a stream. */
function place(tab, keyed) {
  const [, source] = tab.streams.at(-1);
  source.dispatchEvent(Object.assign(new Event("place"), { data: JSON.stringify({ stream: 17, keyed }) }));
}

// A key that the server knows is kept, and given with streams and orders; each stream's number is sent back.
const kept = new Map();
let tab = await open("#key=abc", kept);
tab.module.stream("/events");
assert.equal(tab.streams[0][0], "/events?key=abc");
place(tab, true);
assert.deepEqual(tab.asked, [["/reading?stream=17"]]);
assert.equal(await tab.module.give({ order: "pause" }), null);
assert.deepEqual([tab.asked[1], tab.module.mayOrder, kept.size], [["/control", "abc"], true, 1]);

// The next mission has no key, or another: its first stream says so.
tab = await open("", kept);
assert.equal(tab.module.mayOrder, true, "a reload still has it");
tab.module.stream("/events");
place(tab, false);
assert.deepEqual([tab.module.mayOrder, kept.size, tab.asked], [false, 0, [["/reading?stream=17"]]]);
tab.module.stream("/policy");
assert.equal(tab.streams[1][0], "/policy");

// So does the first order that is refused for its key; one that is refused for another reason does not.
for (const [status, left] of [[403, false], [409, true], [503, true]]) {
  tab = await open("#key=abc", new Map(), { ok: false, status });
  assert.equal(await tab.module.give({ order: "pause" }), "why not");
  assert.deepEqual([tab.module.mayOrder, tab.kept.size === 1], [left, left], `status ${status}`);
}
