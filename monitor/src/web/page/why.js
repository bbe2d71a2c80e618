// Why this hop: the four hops from a cell, with their chances, terms and values.

import { reason as askWhy } from "./transport.js";

/** Answers that are kept: looking back asks nobody twice. */
const KEPT = 512;

/** Pause between two questions. */
const PAUSE_MS = 200;

/** A policy of so many hops ago is no longer shown without a word. */
export const STALE_HOPS = 10;

export const ACTIONS = { n: "north", e: "east", s: "south", w: "west", "-": "hold" };
const ARROWS = { n: "↑", e: "→", s: "↓", w: "←" };
const STEPS = { n: [0, 1], e: [1, 0], s: [0, -1], w: [-1, 0] };

const percent = (share) => (share === 0 ? "0" : share < 0.01 ? (100 * share).toFixed(1) : (100 * share).toFixed(0));
const signed = (value) => (value < 0 ? `−${Math.abs(value).toFixed(2)}` : value.toFixed(2));
/** A difference of values in as many digits as it needs. */
const difference = (value) => (value >= 0.01 ? value.toFixed(2) : value.toPrecision(1));

/** The action of a hop by where it was aimed. */
export function actionOf(aim) {
  if (!aim) return null;
  return Object.keys(STEPS).find((letter) => STEPS[letter][0] === Math.sign(aim[0]) && STEPS[letter][1] === Math.sign(aim[1])) ?? null;
}

export class WhyView {
  constructor(root, history, map, onChange) {
    Object.assign(this, { root, history, map, onChange, answers: new Map(), asked: null, askedAt: 0, shown: "" });
  }

  begin() {
    this.answers.clear();
    this.asked = null;
  }

  /** What the panel is about: a chosen cell, or the hop that led to the moment. */
  subject(at) {
    const { history, map } = this;
    if (map.selected) return { cell: map.selected, decision: at, hop: null };
    const hop = history.hopBefore(at);
    if (hop) return { cell: hop.from, decision: hop.decision, hop };
    return { cell: history.pose(at).cell, decision: at, hop: null };
  }

  /** The answer that is there; another is asked for if the policy has moved on and nobody waits for one. */
  answer({ cell, decision }) {
    const key = `${cell}:${decision}`;
    const known = this.answers.get(key);
    const { history } = this;
    const policy = history.policy?.decision ?? -1;
    // An answer with the policy of its own decision is final.
    const isFinal = known && (known.reason?.policy?.decision === decision || known.policy === policy && known.seen === history.seen);
    const now = performance.now();
    if (!isFinal && !this.asked && history.inside(cell)) {
      if (now - this.askedAt < PAUSE_MS) {
        clearTimeout(this.later);
        this.later = setTimeout(this.onChange, PAUSE_MS);
      } else {
        this.asked = key;
        this.askedAt = now;
        this.ask(cell, decision, key, policy, history.seen);
      }
    }
    return known?.reason ?? null;
  }

  async ask(cell, decision, key, policy, seen) {
    try {
      const reason = await askWhy(cell, decision);
      if (this.answers.size >= KEPT) this.answers.delete(this.answers.keys().next().value);
      this.answers.set(key, { reason, policy, seen });
    } catch {
      this.answers.set(key, { reason: null, policy, seen });
    }
    this.asked = null;
    this.onChange();
  }

  update(at) {
    const subject = this.subject(at);
    const reason = this.answer(subject) ?? (this.last?.key === `${subject.cell}` ? this.last.reason : null);
    if (reason) this.last = { key: `${subject.cell}`, reason };
    const title = this.map.selected ? `Cell (${subject.cell.join(", ")})` : subject.hop ? `This hop` : "Next hop";
    const way = subject.hop ? this.history.wayOf(subject.hop) : null;
    const text = JSON.stringify([title, subject, reason, way]);
    // While an answer is on its way the one before stays, rather than an empty table.
    if (this.shown === text || !reason && this.asked && this.shown) return;
    this.shown = text;
    const { root } = this;
    root.querySelector("h2 > span").textContent = title;
    root.querySelector("#why-number").textContent = this.map.selected ? "Esc: back to the hop" : subject.hop ? `hop ${subject.hop.decision}` : "";
    root.querySelector("p").textContent = this.sentence(subject, reason);
    const note = this.note(subject, reason);
    root.querySelector("#why-note").textContent = note.text;
    root.querySelector("#why-note").className = note.isStale ? "note warn" : "note";
    this.fill(subject, reason);
    this.fillWay(subject, way);
  }

  /** What became of a hop whose motion is physical: told and not believed. */
  fillWay({ hop }, way) {
    const list = this.root.querySelector("#why-way");
    list.hidden = !way?.launch;
    if (list.hidden) return;
    const { cell_size_m: size } = this.history.mission.grid;
    const facts = [["launch", way.speedMps.toFixed(2), `m/s, ${way.angleDeg.toFixed(1)}°`]];
    const { impacts, rolled_m: rolledM } = way.told;
    if (impacts !== undefined) facts.push(["impacts", `${impacts}`, impacts > way.impacts.length ? `, ${way.impacts.length} shown` : ""]);
    if (rolledM !== undefined) facts.push(["rolled", rolledM.toFixed(2), "m"]);
    if (way.lostJPerKg !== null) facts.push(["energy lost", way.lostJPerKg.toFixed(2), "J/kg"]);
    facts.push(["took", way.seconds.toPrecision(3), "s"]);
    const aim = this.history.aimOf(hop);
    if (aim) facts.push(["from the aim", (size * Math.hypot(way.rest[0] - hop.from[0] - aim[0] - 0.5, way.rest[1] - hop.from[1] - aim[1] - 0.5)).toFixed(2), "m"]);
    list.replaceChildren(...facts.map(([name, value, unit]) => {
      const row = document.createElement("div");
      const [term, fact, small] = ["dt", "dd", "small"].map((tag) => document.createElement(tag));
      term.textContent = name;
      small.textContent = unit;
      fact.append(Object.assign(document.createElement("span"), { textContent: value }), small);
      row.append(term, fact);
      return row;
    }));
  }

  sentence({ hop, cell }, reason) {
    const chosen = hop ? actionOf(this.history.aimOf(hop)) : reason?.policy?.action;
    const parts = [];
    if (hop) parts.push(this.outcome(hop, chosen, reason));
    else if (!reason) parts.push(this.history.inside(cell) ? "" : "Off the map.");
    else if (!reason.seen) parts.push("Nobody has seen this cell: planners assume it flat.");
    else parts.push(`${reason.sand ? "Sand" : "Hard ground"}, slope ${reason.slope_deg}°.`);
    const margin = this.margin(chosen, reason);
    if (margin) parts.push(margin);
    const vetoed = hop ? hop.vetoed : reason?.vetoed;
    if (vetoed) parts.push(`The guard vetoed ${[...vetoed].map((letter) => ACTIONS[letter]).join(", ")}.`);
    if (hop && hop.origin !== "planner") parts.push(`No command came in time: the fallback acted (${hop.origin}).`);
    return parts.filter(Boolean).join(" ") || "–";
  }

  outcome(hop, chosen, reason) {
    const hops = reason?.hops.find((one) => one.action === chosen);
    const chance = (n) => (hops ? `, a chance of ${percent(hops.chances[n])} %` : "");
    const name = chosen ? ACTIONS[chosen][0].toUpperCase() + ACTIONS[chosen].slice(1) : "";
    const way = this.history.wayOf(hop);
    if (way && hop.branch !== "held") return this.told(hop, way, name, chance);
    switch (hop.branch) {
      case "intended": return `${name}, landed as aimed${chance(0)}.`;
      case "left": return `${name}, but it slipped to the left${chance(2)}.`;
      case "right": return `${name}, but it slipped to the right${chance(3)}.`;
      case "stayed": return "It got stuck and stayed where it was.";
      case "held": return "It held its place.";
      case "elsewhere": return `${name}, but it came to rest on another cell.`;
      case "rolled_away": return `${name}, and it did not come to rest: it is lost.`;
      case "halted": return "It stopped on its way: the time of the stage was used up.";
      default: return "";
    }
  }

  /** How a hop ended whose motion is physical, beside what was believed of it. */
  told(hop, way, name, chance) {
    const aimed = name ? `${name}: ` : "";
    const where = { intended: "on the cell it was aimed at", left: "on the cell to the left", right: "on the cell to the right", stayed: "on the cell it had left", elsewhere: "on another cell" }[hop.branch];
    const place = { intended: 0, stayed: 1, left: 2, right: 3 }[hop.branch];
    const ending = way.ended === "it came to rest" && where ? `it came to rest ${where}` : way.ended;
    return `${aimed}${ending}${place === undefined ? "" : chance(place)}.`.replace(/^./, (first) => first.toUpperCase());
  }

  /** What the chosen hop is worth beside the next best. */
  margin(chosen, reason) {
    const valued = (reason?.hops ?? []).filter((hop) => hop.value !== null);
    const own = valued.find((hop) => hop.action === chosen);
    if (!own || valued.length < 2) return "";
    const other = valued.filter((hop) => hop !== own).reduce((best, hop) => (hop.value > best.value ? hop : best));
    const more = own.value - other.value;
    const [mine, next] = [ACTIONS[own.action], ACTIONS[other.action]].map((word) => word);
    if (Math.abs(more) < 1e-6) return `${mine[0].toUpperCase()}${mine.slice(1)} and ${next} are worth the same.`;
    if (more > 0) return `${mine[0].toUpperCase()}${mine.slice(1)} is worth ${difference(more)} more than ${next}, the next best.`;
    return `${next[0].toUpperCase()}${next.slice(1)} is worth ${difference(-more)} more under the policy shown.`;
  }

  note({ decision }, reason) {
    if (!reason) return { text: "" };
    if (!reason.policy) return { text: reason.hops.some((hop) => hop.value !== null) ? "" : "no values: the planner in command publishes no policy, or the policy is switched off (P)" };
    if (reason.hops.every((hop) => hop.value === null)) return { text: "no values here: the goal, off the hop lattice, or treasures are planned for" };
    const age = Math.abs(decision - reason.policy.decision);
    return age === 0 ? { text: "" } : { text: `values of ${reason.policy.planner} at hop ${reason.policy.decision}${age > STALE_HOPS ? `, ${age} hops away` : ""}`, isStale: age > STALE_HOPS };
  }

  fill({ hop }, reason) {
    const chosen = hop ? actionOf(this.history.aimOf(hop)) : reason?.policy?.action;
    const vetoed = (hop ? hop.vetoed : reason?.vetoed) ?? "";
    const best = Math.max(...(reason?.hops ?? []).map((one) => one.value ?? -Infinity));
    const cell = (text, className = "n") => Object.assign(document.createElement("td"), { textContent: text, className });
    const rows = (reason?.hops ?? []).map((one) => {
      const row = document.createElement("tr");
      row.className = [one.action === chosen ? "chosen" : "", vetoed.includes(one.action) ? "vetoed" : ""].join(" ").trim();
      const [aimed, stuck, left, right] = one.chances;
      const name = Object.assign(document.createElement("th"), { textContent: `${ARROWS[one.action]} ${ACTIONS[one.action]}`, scope: "row" });
      row.append(name, cell(percent(aimed)), cell(percent(left)), cell(percent(right)), cell(percent(stuck)));
      if (one.terms) row.append(...one.terms.map((term) => cell(signed(term))));
      else row.append(Object.assign(cell(one.ends === "goal" ? "the goal" : one.ends ?? "", "n ends"), { colSpan: 3 }));
      row.append(cell(vetoed.includes(one.action) ? "vetoed" : one.value === null ? "–" : signed(one.value), `n value${one.value === best ? " best" : ""}`));
      return row;
    });
    this.root.querySelector("tbody").replaceChildren(...rows);
  }
}
