// How the page reaches a mission that flies in its own browser: the same streams, answers and orders, out of a worker.

import { Choice } from "./choice.js";

const worker = new Worker(new URL("./worker.js", import.meta.url), { type: "module" });
const asked = new Map();
const streams = { "/events": null, "/policy": null };
const leaders = [];
let number = 0;

/** Asks the worker; what it answers. */
function ask(act, given = {}, transfer = []) {
  number += 1;
  const id = number;
  return new Promise((done, failed) => {
    asked.set(id, { done, failed });
    worker.postMessage({ id, act, ...given }, transfer);
  });
}

/** As an EventSource, whose events come out of the worker. */
class Stream extends EventTarget {
  constructor(path) {
    super();
    this.path = path;
    this.readyState = EventSource.CONNECTING;
    streams[path] = this;
    ready.then(() => {
      if (streams[path] !== this) return;
      this.readyState = EventSource.OPEN;
      this.onopen?.();
      if (path === "/policy") ask("follow", { wanted: true }).catch(() => {});
      else ask("rewind").catch(() => {});
    }, () => this.onerror?.());
  }

  close() {
    this.readyState = EventSource.CLOSED;
    if (streams[this.path] !== this) return;
    streams[this.path] = null;
    if (this.path === "/policy") ask("follow", { wanted: false }).catch(() => {});
  }
}

const TAKES = {
  answer({ id, answer, error }) {
    const { done, failed } = asked.get(id);
    asked.delete(id);
    if (error === undefined) done(answer); else failed(new Error(error));
  },
  frames({ text }) {
    for (const line of text.split("\n").filter(Boolean)) {
      const end = line.indexOf(" ");
      const [event, data] = [line.slice(0, end), line.slice(end + 1)];
      if (event === "mission") {
        leaders.length = 0;
        if (streams["/policy"]) ask("follow", { wanted: true }).catch(() => {});
      }
      if (event === "hops") {
        leaders.push(...JSON.parse(data).leaders);
        if (leaders.length > 0) choice.follow(leaders.at(-1));
      }
      streams[event === "policy" ? "/policy" : "/events"]?.dispatchEvent(new MessageEvent(event, { data }));
    }
  },
  failed({ error }) {
    choice.tell(error);
  },
};

const awake = new Promise((done, failed) => {
  TAKES.ready = done;
  worker.addEventListener("error", (event) => failed(new Error(event.message || "this browser does not run the module")));
});
worker.addEventListener("message", ({ data }) => TAKES[data.type](data));

const choice = new Choice({ ask, leaders });
const ready = awake.then(() => choice.begin()).catch((error) => { choice.tell(error.message); throw error; });
ready.catch(() => {});

/** Orders are given to one's own browser. */
export const mayOrder = true;

/** The history ("/events") or the policies ("/policy"), as the monitor's server would send them. */
export const stream = (path) => new Stream(path);

/** Why a hop from a cell when a decision is due; null if nobody can tell. */
export const reason = ([x, y], at) => ask("why", { question: { x, y, at } });

/** Gives an order; why it was refused, or null. */
export async function give(order) {
  try {
    await ask("order", { order });
    return null;
  } catch (error) {
    return error.message;
  }
}
