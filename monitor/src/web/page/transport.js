// How the page reaches the monitor that serves it. The page without a server has another file in this place:
// crates/browser/page/transport.js.

/** Where the key is kept while this tab is open. */
const KEPT = "hopper-key";

/** The key of orders. It leaves the address, and so the history of the browser; a reload still has it. */
function takeKey() {
  const given = new URLSearchParams(location.hash.slice(1)).get("key");
  try {
    if (given) sessionStorage.setItem(KEPT, given);
    const kept = sessionStorage.getItem(KEPT);
    if (given && kept) history.replaceState(null, "", location.pathname);
    return kept;
  } catch {
    return given;
  }
}

let key = takeKey();

/** Whether this page may give orders. */
export let mayOrder = Boolean(key);

/** Drops a key that the server does not accept: the tab has kept it from an earlier mission at the same address. */
function dropKey() {
  [key, mayOrder] = [null, false];
  try {
    sessionStorage.removeItem(KEPT);
  } catch {
    // Where nothing can be kept, nothing was.
  }
}

/** The history ("/events") or the policies ("/policy") as server-sent events. A stream with the key has a place that no reader without it can take. */
export function stream(path) {
  const source = new EventSource(key ? `${path}?key=${encodeURIComponent(key)}` : path);
  source.addEventListener("place", ({ data }) => {
    const place = JSON.parse(data);
    if (key && !place.keyed) dropKey();
    // A stream whose reader does not send this back makes room for others.
    fetch(`/reading?stream=${place.stream}`).catch(() => {});
  });
  return source;
}

/** Why a hop from a cell when a decision is due; null if nobody can tell. */
export async function reason([x, y], at) {
  const answer = await fetch(`/why?x=${x}&y=${y}&at=${at}`);
  return answer.ok ? answer.json() : null;
}

/** Gives an order; why it was refused, or null. */
export async function give(order) {
  const answer = await fetch("/control", {
    method: "POST", headers: { "Content-Type": "application/json", "X-Hopper-Key": key ?? "" }, body: JSON.stringify(order),
  });
  if (answer.status === 403) dropKey();
  return answer.ok ? null : (await answer.text()).trim();
}
