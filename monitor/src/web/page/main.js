// The page: frames in, pixels out.

import { MissionHistory } from "./history.js";
import { drawBar, drawHistogram, drawHistory, drawLine } from "./charts.js";
import { figuresOf, toGoalM } from "./figures.js";
import { keysOf } from "./legend.js";
import { MapView, drawRamp } from "./map.js";
import { GROUND, robotColour } from "./palette.js";
import { duration, fixed, missionTime } from "./scale.js";
import { SpaceView } from "./space.js";
import { ACTIONS, STALE_HOPS, WhyView } from "./why.js";
import * as theme from "./theme.js";
import { give, mayOrder, stream } from "./transport.js";

const by = (id) => document.getElementById(id);
const history = new MissionHistory();
const view = { at: Infinity, logarithmic: true, replay: 0, dirty: true, turned: false, connected: "connecting", retry: 0 };
const map = new MapView(by("map"), history, () => { view.dirty = true; });
const why = new WhyView(by("why"), history, map, () => { view.dirty = true; });
const space = new SpaceView(by("space-view"), history, map, () => { view.turned = true; });
const calm = window.matchMedia("(prefers-reduced-motion: reduce)");
/** Maps up to this many cells show the policy from the start; on larger ones the hopper is followed. */
const SMALL_CELLS = 4096;

/** Pause before the page connects again: after it lost the connection, and after it was refused since all places are taken. */
const LOST_MS = 1500;
const FULL_MS = 5000;

/** What befell a stray hop. */
const STRAYED = {
  stayed: "stuck: the hop got nowhere", left: "stray hop, slipped to the left", right: "stray hop, slipped to the right",
  elsewhere: "stray hop, came to rest on another cell", rolled_away: "the hopper did not come to rest",
};

/** A way that takes longer is shown in time lapse. */
const WAY_MAX_MS = 12000;

/** Hops that follow each other faster are not shown in flight. */
const FLIGHT_GAP_MS = 80;

const TEXTS = new Map();

let source = null;
let policies = null;
let retry = 0;

/** Sets a text, if it differs: most do not. */
function put(id, text) {
  if (TEXTS.get(id) === text) return;
  TEXTS.set(id, text);
  by(id).textContent = text;
}

function make(tag, properties = {}, ...children) {
  const node = Object.assign(document.createElement(tag), properties);
  node.append(...children);
  return node;
}

/** The moment that is shown: a decision, the one that is due if nothing else is asked for. */
function moment() {
  return history.mission ? Math.min(Math.max(view.at, history.first), history.due) : 0;
}

const isLive = () => view.at === Infinity;

// Frames.

function connect() {
  clearTimeout(retry);
  source?.close();
  if (document.hidden) return;
  source = stream("/events");
  const on = (event, take) => source.addEventListener(event, ({ data }) => {
    take(JSON.parse(data));
    view.dirty = true;
  });
  source.onopen = () => { view.connected = "open"; view.dirty = true; };
  source.onerror = () => {
    // A browser asks again by itself, unless it got an answer that is no stream.
    const isRefused = source.readyState === EventSource.CLOSED;
    source.close();
    view.dirty = true;
    if (view.connected === "bye") return;
    view.connected = isRefused ? "full" : "lost";
    retry = setTimeout(connect, isRefused ? FULL_MS : LOST_MS);
  };
  on("mission", (mission) => {
    const known = history.mission?.run === mission.run;
    const zoom = [map.zoom, map.centre];
    history.begin(mission);
    map.begin();
    why.begin();
    space.begin();
    if (!known) {
      const small = mission.grid.width * mission.grid.height <= SMALL_CELLS;
      [map.options.policy, map.options.follow] = [small && history.robots === 1, !small && (history.robots === 1 || mission.hops)];
      followPolicies();
    }
    chooseLayers(known);
    if (known) [map.zoom, map.centre] = zoom; else view.at = Infinity;
    beginMission(mission);
  });
  on("hops", (frame) => history.addHops(frame));
  on("cells", (frame) => history.addCells(frame));
  on("routes", (route) => history.addRoute(route));
  on("details", (frame) => history.addDetails(frame));
  on("speeds", (frame) => history.addSpeeds(frame));
  on("marks", (marks) => history.marks.push(...marks));
  on("status", (status) => { history.status = status; });
  on("bye", () => { view.connected = "bye"; source.close(); policies?.close(); });
}

/** Policies are a stream of their own, open while somebody looks at them: they cost the planner something. */
function followPolicies() {
  const wanted = !document.hidden && (map.options.policy || map.options.values);
  if (wanted === Boolean(policies)) return;
  policies?.close();
  policies = wanted ? stream("/policy") : null;
  policies?.addEventListener("policy", ({ data }) => {
    history.addPolicy(JSON.parse(data));
    view.dirty = true;
  });
  policies?.addEventListener("error", ({ target }) => {
    // Refused, since all places are taken: a browser does not ask again by itself.
    if (target !== policies || target.readyState !== EventSource.CLOSED) return;
    policies = null;
    setTimeout(followPolicies, FULL_MS);
  });
}

/** A page that nobody sees lets go of both its streams: a browser has six for all pages of one address. */
function attend() {
  if (view.connected === "bye") return;
  followPolicies();
  Object.assign(view, { connected: "connecting", dirty: true });
  connect();
}

function beginMission(mission) {
  put("scenario", mission.scenario);
  put("profile", mission.profile);
  put("run", mission.run.slice(0, 8));
  by("run").title = mission.run;
  const items = mission.stages.map((name) => {
    const item = make("li", { className: name === "map" ? "map-stage" : name }, make("span", { textContent: name }), make("b", { id: `stage-${name}` }));
    return item;
  });
  items.push(make("li", { className: "total" }, make("span", { textContent: "total" }), make("b", { id: "stage-total" })));
  by("stages").replaceChildren(...items);
  by("figures").replaceChildren();
  [...TEXTS.keys()].filter((id) => id.startsWith("stage-")).forEach((id) => TEXTS.delete(id));
}

/** The layers of this mission, and which of them is shown: at first the one that the monitor marks. */
function chooseLayers(known) {
  const layers = map.layers();
  by("layer").replaceChildren(...layers.map(({ name, menu }) => make("option", { value: name, textContent: menu })));
  by("layer-choice").hidden = layers.length < 2;
  const isKept = known && layers.some(({ name }) => name === map.options.layer);
  showLayer(isKept ? map.shown() : layers.find(({ first }) => first));
}

/** Names in the legend what is drawn. */
function showKeys(at) {
  const { mission } = history;
  const shown = keysOf({ history, map, inSpace: view.space }, at);
  for (const key of document.querySelectorAll("[data-key]")) key.hidden = !shown[key.dataset.key];
  put("blocked-name", mission.hops || mission.speeds ? "impassable" : "obstacle");
  if (map.lines) put("contour-step", `${map.lines.stepM}`);
}

function showLayer(layer) {
  map.choose(layer.name);
  by("layer").value = layer.name;
  drawRamp(by("ramp"), layer.ramp ?? GROUND);
  put("unit", layer.legend);
  view.dirty = true;
}

function nextLayer() {
  const layers = map.layers();
  if (layers.length > 1) showLayer(layers[(layers.indexOf(map.shown()) + 1) % layers.length]);
}

// What stands beside the map.

/** What people call a robot by its body. */
const KINDS = { driver: "rover" };

/** The number of a robot in its colour, and in the shape that it has on the map. */
function badgeOf(robot) {
  const { body } = history.mission.robots[robot];
  const badge = make("i", { className: `badge ${body}`, textContent: robot });
  badge.style.background = robotColour(robot);
  return badge;
}

/** The robots, each with its colour and number. */
function showRobots(at) {
  const isTeam = history.robots > 1;
  by("robots-section").hidden = !isTeam;
  if (!isTeam) return;
  const due = history.turn(at);
  const rows = history.poses(at).map(({ cell, standing }, robot) => {
    const { body } = history.mission.robots[robot];
    const toGoal = toGoalM(history, robot, cell);
    return [robot, KINDS[body] ?? body, history.plannerOf(robot, at) ?? "–", cell ? `(${cell.join(", ")})` : "–", toGoal === null ? "" : `${toGoal.toFixed(0)} m`, robot === due ? "its turn" : standing.replace("_", " ")];
  });
  const text = JSON.stringify(rows);
  if (TEXTS.get("robots") === text) return;
  TEXTS.set("robots", text);
  by("robots").tBodies[0].replaceChildren(...rows.map(([robot, kind, planner, cell, toGoal, standing]) => {
    const goal = make("td", toGoal ? {} : { textContent: "–" });
    if (toGoal) {
      const star = make("i", { className: "star", textContent: "★" });
      star.style.color = robotColour(robot);
      goal.append(star, toGoal);
    }
    return make("tr", { className: robot === due ? "chosen" : "" }, make("td", {}, badgeOf(robot)), ...[kind, planner, cell].map((textContent) => make("td", { textContent })), goal, make("td", { textContent: standing }));
  }));
}

function showFigures(at) {
  const list = by("figures");
  const all = figuresOf(history, at, isLive());
  // More robots than these have no room beside a name.
  const robotsOf = (robots) => (robots.length > 3 ? [] : robots);
  if (list.children.length === 0) list.append(...all.map(() => make("div", {}, make("dt"), make("dd", {}, make("span"), make("small")))));
  all.forEach(([name, value, unit, robots = []], n) => {
    const [term, fact] = list.children[n].children;
    const [number, small] = fact.children;
    if (term.dataset.figure !== `${name}:${robots}`) {
      term.dataset.figure = `${name}:${robots}`;
      term.replaceChildren(name, ...robotsOf(robots).map(badgeOf));
    }
    if (number.textContent !== value) number.textContent = value;
    if (small.textContent !== unit) small.textContent = unit;
  });
}

function showTimes(at) {
  const { mission } = history;
  const hop = history.hopBefore(at);
  drawBar(by("bar"), hop, mission.stages, mission.budget_us);
  mission.stages.forEach((name, n) => put(`stage-${name}`, hop ? duration(hop.stages[n]) : "–"));
  put("stage-total", hop ? duration(hop.totalUs) : "–");
  put("blame", hop ? history.blame(hop)?.text ?? "" : "");
  const count = drawHistory(by("history"), history, at, mission.budget_us, mission.stages, view.logarithmic);
  put("history-note", count > 0 ? `the last ${count}` : "");
  const { p50, p99, longest } = drawHistogram(by("histogram"), history, at, mission.budget_us);
  const misses = history.status?.progress?.latency?.misses ?? 0;
  const missed = isLive() ? ` · ${misses} missed` : "";
  put("histogram-note", hop ? `p50 ${duration(p50)} · p99 ${duration(p99)} · max ${duration(longest)}${missed}` : "");
  by("bar").setAttribute("aria-label", hop ? `Decision ${hop.decision}: ${duration(hop.totalUs)} of a budget of ${duration(mission.budget_us)}; ${mission.stages.map((name, n) => `${name} ${duration(hop.stages[n])}`).join(", ")}` : "No decision yet");
}

/** A bound on values as its planner proves it; planners without values claim none. */
function bound(value) {
  return value > 0 ? `${value.toExponential(1)}` : "–";
}

function showLeaders(at) {
  const until = history.leaders.filter((leader) => leader.from < at || at === history.due);
  const rows = until.slice(-Math.max(8, 2 * history.robots)).reverse().map((leader) => [leader, history.commands(leader, at)]);
  const text = rows.map(([leader, hops]) => `${leader.robot}:${leader.term}:${hops}:${history.bounds.get(leader.term)}`).join();
  if (TEXTS.get("leaders") === text) return;
  TEXTS.set("leaders", text);
  by("leaders").tBodies[0].replaceChildren(...rows.map(([leader, hops]) => make("tr", { className: `p${history.plannerNumber(leader.planner)}` },
    make("td", { textContent: leader.term }),
    make("td", {}, make("i", { className: "swatch" }), `${history.robotPrefix(leader.robot)}${leader.planner}`),
    make("td", { className: "n", textContent: leader.from }),
    make("td", { className: "n", textContent: hops }),
    make("td", { className: "n", textContent: bound(history.bounds.get(leader.term)) }),
    make("td", { className: "n", textContent: leader.pid || "–" }))));
}

/** Which of several robots, as the end of a phrase. */
function ofRobots(robots, before = "") {
  if (history.robots === 1 || robots.length === 0) return "";
  return ` ${before}robot${robots.length > 1 ? "s" : ""} ${robots.join(", ")}`;
}

/** Planners that command nobody and could take over. */
const standBy = () => (history.status?.peers ?? []).filter(({ role, alive, leads }) => role === "planner" && alive && leads.length === 0);

/** Has a planner take command. A paused mission goes on only when somebody lets it. */
function handOver(peer) {
  const waits = history.status?.tempo?.paused ? "; the mission is paused: Step or Go on for it to decide" : "";
  tell({ order: "hand_over", life: peer.life }, `${peer.planner} takes command${ofRobots(peer.plans, "of ")}${waits}`);
}

/** Hands over to the planner that stands by; of several somebody chooses. */
function askWho() {
  if (!mayOrder || view.connected !== "open") return;
  const planners = standBy();
  if (planners.length === 0) {
    say("no planner stands by");
    return;
  }
  if (planners.length === 1) {
    handOver(planners[0]);
    return;
  }
  by("standby-list").replaceChildren(...planners.map((peer) => {
    const button = make("button", { type: "button", textContent: `${peer.planner}${ofRobots(peer.plans, "for ")} (${peer.pid})` });
    button.addEventListener("click", () => { by("standby").close(); handOver(peer); });
    return make("li", {}, button);
  }));
  by("standby").showModal();
}

function showPeers() {
  const peers = history.status?.peers ?? [];
  const status = history.status?.progress?.status;
  const interrupted = Boolean(history.status?.interrupted);
  const over = interrupted || (status && status !== "underway");
  const text = JSON.stringify(peers.map((peer) => [peer.life, peer.alive, peer.leads, peer.plans, Math.round(peer.silent_ms / 200)])) + view.connected + over + interrupted + mayOrder;
  if (TEXTS.get("peers") === text) return;
  TEXTS.set("peers", text);
  by("peers").tBodies[0].replaceChildren(...peers.map((peer) => {
    const state = over ? "finished" : !peer.alive ? "silent" : peer.silent_ms > 400 ? "late" : "alive";
    const last = make("td", { className: "n" });
    if (peer.role === "planner" && peer.alive && peer.leads.length === 0 && !over) {
      const button = make("button", { type: "button", textContent: "hand over", disabled: !mayOrder || view.connected !== "open", title: mayOrder ? `Let ${peer.planner} command${ofRobots(peer.plans)}` : "needs --control" });
      button.addEventListener("click", () => handOver(peer));
      last.append(button);
    }
    const part = peer.role === "planner" ? (peer.leads.length > 0 ? `commands${ofRobots(peer.leads)}` : `stands by${ofRobots(peer.plans, "for ")}`) : peer.alive ? "alive" : "silent";
    return make("tr", { className: state },
      make("td", {}, make("i", { className: "dot" }), peer.planner ? `${peer.role} ${peer.planner}` : peer.role),
      make("td", { textContent: interrupted ? "ended" : over ? "finished" : peer.alive ? part : "silent" }),
      make("td", { className: "n", textContent: peer.pid }),
      make("td", { className: "n", textContent: over ? "" : peer.silent_ms < 1000 ? `${peer.silent_ms} ms` : `${(peer.silent_ms / 1e3).toFixed(1)} s` }),
      last);
  }));
}

/** What befell the hops of late, and what the guard did: the last thousand are looked through. */
function guarded(at) {
  const until = Math.max(at - history.first, 0);
  return history.hops.slice(Math.max(until - 1000, 0), until).flatMap(({ decision, robot, vetoed, origin, stray, branch, stages, totalUs }) => {
    const who = history.robotPrefix(robot);
    const events = [];
    if (vetoed) events.push({ decision, kind: "swap", text: `${who}the guard vetoes ${[...vetoed].map((letter) => (letter === "-" ? "to stand still" : ACTIONS[letter])).join(", ")}` });
    if (stray) events.push({ decision: decision + 1, kind: "stray", text: `${who}${STRAYED[branch]}` });
    if (totalUs > history.mission.budget_us) {
      const blame = history.blame({ decision, robot, stages, totalUs });
      events.push({ decision, kind: "bad", text: `${who}budget missed: ${duration(totalUs)} of ${duration(history.mission.budget_us)}${blame ? `; ${blame.text}` : ""}` });
    }
    if (origin !== "planner") events.push({ decision, kind: "bad", text: `${who}no command in time: the fallback acts (${origin})` });
    return events;
  });
}

function showEvents(at) {
  const swaps = history.leaders.filter((leader) => !leader.first).map((leader) => ({ decision: leader.from, kind: "swap", text: `${history.robotPrefix(leader.robot)}${leader.planner} takes command, term ${leader.term}` }));
  const changes = history.marks.map((mark) => {
    const who = mark.planner ? `${mark.role} ${mark.planner}` : mark.role;
    const words = { joined: "joined", silent: "fell silent", back: "is back" }[mark.change];
    return { decision: mark.decision, kind: mark.change === "silent" ? "bad" : mark.change === "back" ? "good" : "", text: `${who} (${mark.pid}) ${words}` };
  });
  const last = history.hopBefore(history.due);
  const end = last && last.status !== "underway" ? [{ decision: history.due, kind: last.status === "goal" ? "good" : "bad", text: `the mission is over: ${last.status}` }] :
    history.status?.interrupted ? [{ decision: history.due, kind: "bad", text: "the mission was interrupted" }] : [];
  const all = [...changes, ...swaps, ...guarded(at), ...end].filter((event) => event.decision <= at);
  const text = `${all.length}:${at === history.due}:${end.length}`;
  if (TEXTS.get("events") === text) return;
  TEXTS.set("events", text);
  all.reverse().sort((a, b) => b.decision - a.decision);
  by("events").replaceChildren(...all.slice(0, 100).map((event) => make("li", { className: event.kind },
    make("b", { textContent: `${history.decisionWord} ${event.decision}` }), make("span", { textContent: event.text }))));
}

function measuredPace(at) {
  const hops = history.hops.slice(Math.max(at - history.first - 9, 0), Math.max(at - history.first, 0));
  if (hops.length < 2) return null;
  const ms = hops[hops.length - 1].landedMs - hops[0].landedMs;
  return ms > 0 ? ((hops.length - 1) * 1e3) / ms : null;
}

function showHead(at) {
  const progress = history.status?.progress;
  const tempo = history.status?.tempo;
  const silent = (history.status?.peers ?? []).filter((peer) => !peer.alive).length;
  const over = progress && progress.status !== "underway";
  const missing = history.status?.missing;
  let [text, kind] = ["waiting for a mission", "warn"];
  if (view.connected === "bye") [text, kind] = [over ? `over: ${progress.status}` : history.status?.interrupted ? "interrupted" : "the monitor has left", progress?.status === "goal" ? "good" : "warn"];
  else if (view.connected !== "open") [text, kind] = [{ lost: "no connection", full: "no place: other pages have all" }[view.connected] ?? "connecting", "bad"];
  else if (over) [text, kind] = [progress.status === "goal" ? "goal reached" : progress.status, progress.status === "goal" ? "good" : "bad"];
  else if (!isLive()) [text, kind] = ["looking back", "warn"];
  else if (history.status?.interrupted) [text, kind] = ["interrupted", "warn"];
  else if (tempo?.paused) [text, kind] = ["paused", "warn"];
  else if (progress?.missing > 0) [text, kind] = [`catching up: ${progress.missing} hops`, "warn"];
  else if (missing) [text, kind] = [`waiting for ${missing.peer}: ${missing.command}`, "warn"];
  else if (progress) [text, kind] = [silent ? "under way, somebody is silent" : "under way", silent ? "warn" : "good"];
  put("status", text);
  by("status").className = `chip ${kind}`;
  const leader = history.leaderAt(at);
  put("clock", missionTime(history.timeAt(at), history.mission?.speeds));
  put("leader", leader ? `${history.robotPrefix(leader.robot)}${leader.planner}, term ${leader.term}` : "nobody yet");
  const pace = measuredPace(at);
  put("pace", [pace ? `${pace < 9.95 ? pace.toFixed(1) : pace.toFixed(0)} ${history.decisionWord}s/s` : "–", tempo && isLive() ? `(${tempo.paused ? "paused, " : ""}${/^[\d.]+$/.test(tempo.pace) ? `${tempo.pace} asked` : tempo.pace})` : ""].join(" "));
  document.title = history.mission ? `${text} · ${history.decisionWord} ${history.due} · Hopper` : "Hopper";
}

function policyNote(at) {
  if (!map.options.policy && !map.options.values) return "";
  const policy = map.policyAt(at);
  if (policy) {
    const certified = policy.error_bound > 0 ? ` · |V − V*| ≤ ${bound(policy.error_bound)}` : "";
    const age = map.age(policy, at);
    const old = age > STALE_HOPS ? `, ${age} hops away from this moment` : "";
    return `${old ? "⚠ " : ""}policy of ${policy.planner} at hop ${policy.decision}${old}${certified}`;
  }
  const planner = history.plannerAt(at);
  return planner ? `no policy of ${planner}` : "";
}

function showControls() {
  const tempo = history.status?.tempo;
  const allowed = mayOrder && Boolean(tempo?.heeds) && view.connected === "open";
  const why = !mayOrder ? "needs a monitor started with --control" : "needs a hopper-sim started with --control";
  for (const id of ["pause", "step", "tempo"]) by(id).disabled = !allowed;
  by("step").disabled = !allowed || !tempo?.paused;
  put("pause", tempo?.paused ? "Go on" : "Pause");
  if (!allowed && !TEXTS.get("answer")) by("answer").title = why;
  by("pause").title = allowed ? "Pause or go on (space)" : why;
}

/** Shows the hop that leads to a moment in flight, if it came one hop after the one before and there is time for it. */
function fly(at) {
  if (at === view.shownAt) return;
  const now = performance.now();
  const gap = Math.min(now - view.shownSince, 2000);
  if (at === view.shownAt + 1 && gap >= FLIGHT_GAP_MS && !calm.matches && history.robots === 1) {
    const squeezed = Math.min(0.75 * gap, 700);
    map.launch(at, (way) => (way ? wayMs(way, 0.75 * gap) : squeezed));
  }
  [view.shownAt, view.shownSince] = [at, now];
}

/** How long the way of a hop is shown: as long as it took, or so many times faster as landings are paced; in time lapse where hops follow each
 * other faster, or it took too long. */
function wayMs(way, gapMs) {
  const pace = history.status?.tempo?.pace ?? "";
  const times = isLive() ? Number(/^([\d.]+)x$/.exec(pace)?.[1] ?? 1) : 1;
  const isPacedByTime = isLive() && /^(real|[\d.]+x)$/.test(pace);
  const isFollowed = !isPacedByTime && (isLive() || view.replay);
  return Math.min((1000 * way.seconds) / times, WAY_MAX_MS, isFollowed ? gapMs : Infinity);
}

/** How far the hop in flight is, in words. */
function flightNote(at) {
  const flight = map.flightAt(at);
  if (!flight?.way) return "";
  const { way, share, ms } = flight;
  const times = (1000 * way.seconds) / ms;
  return `${(share * way.seconds).toFixed(1)} of ${way.seconds.toFixed(1)} s${times > 1.05 || times < 0.95 ? `, ${times.toPrecision(2)} ×` : ""}`;
}

function showReadout(at) {
  put("readout", [flightNote(at), view.space ? `heights ×${(space.raised ?? 1).toFixed(1)}` : map.reading(at)].filter(Boolean).join(" · "));
}

function show() {
  requestAnimationFrame(show);
  if (!view.dirty) {
    // Only the eye has moved, or a hop is in flight: nothing else of the page changes.
    const draws = view.turned && view.space && history.mission;
    view.turned = false;
    if (draws) {
      space.draw(moment(), map.policyAt(moment()));
      showReadout(moment());
    }
    return;
  }
  [view.dirty, view.turned] = [false, false];
  if (!history.mission) {
    showHead(0);
    return;
  }
  const at = moment();
  fly(at);
  map.update(isLive() ? Infinity : at);
  if (view.space) space.draw(at, map.policyAt(at));
  else map.draw(at);
  showReadout(at);
  put("policy-note", policyNote(at));
  by("policy-note").classList.toggle("warn", policyNote(at).startsWith("⚠"));
  by("value-key").hidden = !map.options.values;
  why.update(at);
  showRobots(at);
  const { most } = map.shown();
  const [low, high] = most ? [0, most] : map.range;
  const digits = high - low < 1 ? 2 : high - low < 20 ? 1 : 0;
  put("low", fixed(low, digits));
  put("high", fixed(high, digits));
  showKeys(at);
  showHead(at);
  showFigures(at);
  showTimes(at);
  showLeaders(at);
  showPeers();
  showEvents(at);
  showControls();
  drawLine(by("line"), history, at);
  const slider = by("moment");
  if (slider.min !== `${history.first}`) slider.min = history.first;
  if (slider.max !== `${history.due}`) slider.max = history.due;
  if (slider.value !== `${at}`) slider.value = at;
  slider.setAttribute("aria-valuetext", `${history.decisionWord} ${at} of ${history.due}`);
  put("at", `${history.decisionWord} ${at} of ${history.due}`);
  by("live").setAttribute("aria-pressed", isLive());
  by("play").textContent = view.replay ? "❚❚" : "▶";
  for (const option of ["policy", "values", "follow"]) by(option).setAttribute("aria-pressed", map.options[option]);
  by("log").setAttribute("aria-pressed", view.logarithmic);
  by("contrast").setAttribute("aria-pressed", theme.isStark());
  by("map").setAttribute("aria-label", `Map as discovered by ${history.decisionWord} ${at}, ${map.shown().menu}: ${history.mission.hops ? "hopper" : "last robot"} at cell ${history.pose(at).cell.join(", ")}`);
}

// Time.

function go(at) {
  view.at = at >= history.due ? Infinity : Math.max(at, history.first ?? 0);
  view.dirty = true;
}

function stopReplay() {
  clearInterval(view.replay);
  view.replay = 0;
  view.dirty = true;
}

function replay() {
  if (view.replay) return stopReplay();
  if (!history.mission) return undefined;
  if (isLive()) go(history.first);
  // Any mission in half a minute, or ten hops a second.
  const stride = Math.max(1, Math.round((history.due - history.first) / 600));
  view.replay = setInterval(() => {
    go(moment() + stride);
    if (isLive()) stopReplay();
  }, stride > 1 ? 50 : 100);
  return undefined;
}

// Orders.

/** How long an answer to an order stands. */
const ANSWER_MS = 6000;

/** Shows an answer for a while. */
function say(text) {
  put("answer", text);
  by("answer").title = text;
  view.dirty = true;
  clearTimeout(view.answer);
  view.answer = setTimeout(() => put("answer", ""), ANSWER_MS);
}

/** Gives an order; says why it was refused, or `sent`. */
async function tell(order, sent = `sent: ${order.order.replace("_", " ")}`) {
  try {
    say((await give(order)) ?? sent);
  } catch {
    say("the monitor does not answer");
  }
}

function toggle(option) {
  map.options[option] = !map.options[option];
  if (option === "follow" && !map.options.follow) map.turnTo(1);
  followPolicies();
  view.dirty = true;
}

/** Shows the ground in space, or as a map. */
function inSpace(wanted) {
  view.space = wanted && space.open();
  by("space-view").hidden = !view.space;
  by("space").setAttribute("aria-pressed", Boolean(view.space));
  if (wanted && !view.space) put("readout", "this browser has no WebGL 2");
}

function closer(factor) {
  if (view.space) space.magnify(factor);
  else map.magnify(factor);
}

const KEYS = {
  Home: () => go(history.first),
  End: () => go(Infinity),
  r: replay,
  p: () => toggle("policy"),
  v: () => toggle("values"),
  f: () => toggle("follow"),
  "+": () => closer(1.5),
  "=": () => closer(1.5),
  "-": () => closer(1 / 1.5),
  0: () => { map.options.follow = false; map.turnTo(1); space.distance = 1; },
  m: nextLayer,
  3: () => inSpace(!view.space),
  l: () => { view.logarithmic = !view.logarithmic; },
  t: () => { theme.toggleTheme(); map.recolour(); },
  c: () => { theme.toggleContrast(); map.recolour(); },
  k: () => { if (!by("pause").disabled) tell({ order: history.status?.tempo?.paused ? "resume" : "pause" }); },
  s: () => { if (!by("step").disabled) tell({ order: "step" }); },
  h: askWho,
  " ": () => KEYS.k(),
  PageUp: () => go(moment() - 10),
  PageDown: () => go(moment() + 10),
  Escape: () => { if (map.selected) map.select(null); else { stopReplay(); go(Infinity); } },
  "?": () => by("help").showModal(),
};

function listen() {
  const click = (id, act) => by(id).addEventListener("click", () => { act(); view.dirty = true; });
  for (const [id, name] of [["first", "Home"], ["live", "End"], ["play", "r"], ["policy", "p"], ["values", "v"], ["follow", "f"],
    ["space", "3"], ["closer", "+"], ["farther", "-"], ["fit", "0"], ["log", "l"], ["theme", "t"], ["contrast", "c"], ["keys", "?"], ["pause", "k"], ["step", "s"]]) {
    click(id, KEYS[name]);
  }
  click("back", () => go(moment() - 1));
  click("ahead", () => go(moment() + 1));
  by("moment").addEventListener("input", (event) => { stopReplay(); go(Number(event.target.value)); });
  by("layer").addEventListener("change", (event) => showLayer(map.layers().find(({ name }) => name === event.target.value)));
  by("tempo").addEventListener("change", (event) => {
    if (event.target.value) tell({ order: "pace", pace: event.target.value });
    event.target.value = "";
  });
  document.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || event.target.tagName === "SELECT" || by("help").open || by("standby").open) return;
    if (event.key === " " && event.target.tagName === "BUTTON") return;
    const stride = event.shiftKey ? 10 : 1;
    const act = event.key === "ArrowLeft" ? () => go(moment() - stride) : event.key === "ArrowRight" ? () => go(moment() + stride) : KEYS[event.key] ?? KEYS[event.key.toLowerCase()];
    if (!act) return;
    event.preventDefault();
    if (["ArrowLeft", "ArrowRight", "Home", "End", "PageUp", "PageDown"].includes(event.key)) stopReplay();
    act();
    view.dirty = true;
  });
  document.addEventListener("visibilitychange", attend);
  new ResizeObserver(() => { view.dirty = true; }).observe(document.body);
  new ResizeObserver(() => { view.dirty = true; }).observe(by("map"));
}

theme.begin();
drawRamp(by("value-ramp"));
listen();
connect();
show();
