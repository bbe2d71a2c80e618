// Flies missions beside the page, so that the page stays fluid however long a planner thinks.

import { load } from "./module.js";

/** How long turns go on before frames are sent, milliseconds. */
const SLICE_MS = 25;

/** Pause after turns in which nothing happened, milliseconds. */
const IDLE_MS = 8;

/** Turns without a decision after which nothing happens: a landing takes one, the map's pages at the start a few. */
const IDLE_TURNS = 4;

/** Turns of the monitor after the end, so that it tells of it. */
const LAST_TURNS = 4;

/** Longest gap between slices that is flight time: a browser stops what nobody sees, and nobody fell silent meanwhile. */
const GAP_MS = 100;

/** An order to pause takes effect within this many hops. */
const EARLY_HOPS = 3;

let skippedMs = 0;
let endedMs = performance.now();
const call = await load(await fetch(new URL("./hopper.wasm", import.meta.url)), () => performance.now() - skippedMs);

/** The mission under way: when to stop, and how many turns are left once it is over. */
let flight = null;

function slice() {
  if (!flight) return;
  const begun = performance.now();
  skippedMs += Math.max(begun - endedMs - GAP_MS, 0);
  let idle = 0;
  try {
    while (performance.now() - begun < SLICE_MS && idle < IDLE_TURNS && flight.turns > 0) {
      const { decision, over } = JSON.parse(call("turn"));
      idle = decision === flight.decision ? idle + 1 : 0;
      flight.decision = decision;
      if (over) flight.turns -= 1;
      if (flight.until !== null && approach(decision, idle)) idle = 0;
    }
    send();
  } catch (error) {
    flight = null;
    postMessage({ type: "failed", error: error.message });
  }
  endedMs = performance.now();
  if (flight?.turns > 0) setTimeout(slice, idle < IDLE_TURNS ? 0 : IDLE_MS);
}

/** Stops at a hop exactly: paused a few hops before it, then step by step. Whether it gave an order. */
function approach(decision, idle) {
  if (!flight.held) {
    flight.held = decision >= flight.until - EARLY_HOPS;
    if (flight.held) call("order", { order: "pause" });
    return flight.held;
  }
  if (idle < IDLE_TURNS) return false;
  const there = decision >= flight.until || flight.turns < LAST_TURNS;
  call("order", there ? { order: "pace", pace: flight.pace } : { order: "step" });
  if (there) flight.until = null;
  return true;
}

/** Sends what the page has not seen. */
function send() {
  for (;;) {
    const text = call("frames");
    if (text === "") return;
    postMessage({ type: "frames", text });
  }
}

const ACTS = {
  choices: () => JSON.parse(call("choices")),
  ground: ({ bytes }) => call("ground", new Uint8Array(bytes)),
  begin: ({ request, until, pace }) => {
    const begun = JSON.parse(call("begin", request));
    const idle = !flight || flight.turns <= 0;
    flight = { turns: LAST_TURNS, decision: -1, until, pace, held: false };
    if (idle) setTimeout(slice, 0);
    return begun;
  },
  order: ({ order }) => call("order", order),
  /** Whether it was in time: nobody takes command of a mission that is over. */
  hand_over: ({ planner }) => {
    if (!flight || flight.turns < LAST_TURNS) return false;
    call("hand_over", planner);
    return true;
  },
  why: ({ question }) => JSON.parse(call("why", question)),
  follow: ({ wanted }) => call("follow_policies", undefined, Number(wanted)),
  rewind: () => {
    call("rewind");
    send();
  },
};

addEventListener("message", ({ data }) => {
  try {
    postMessage({ type: "answer", id: data.id, answer: ACTS[data.act](data) });
  } catch (error) {
    postMessage({ type: "answer", id: data.id, error: error.message });
  }
});
postMessage({ type: "ready" });
