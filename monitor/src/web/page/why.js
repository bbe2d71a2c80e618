// Why this hop: the four hops from a cell, with their chances, terms and values; of a rover or a helicopter, what it did and by which rule.

import { fixed } from "./scale.js";
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
const signed = (value) => fixed(value, 2);
/** A difference of values in as many digits as it needs. */
const difference = (value) => (value >= 0.01 ? value.toFixed(2) : value.toPrecision(1));

/** How the planners without values decide. */
const RULES = {
  greedy: "greedy looks one hop ahead: it aims at the landing with the largest payoff, which is safety + info + distance",
  astar: "astar has no values: it takes the first hop of the cheapest route to the goal over the ground as believed",
  dstar_lite: "dstar_lite has no values: it takes the first hop of the cheapest route to the goal over the ground as believed",
  hold: "hold never moves",
  cover_frontier: "cover_frontier goes to the nearest cell that nobody has covered",
  spiral: "spiral sweeps in a spiral", spiral_circumnavigation: "spiral_circumnavigation sweeps in a spiral, beside obstacles first",
  boustrophedon: "boustrophedon sweeps there and back", boustrophedon_circumnavigation: "boustrophedon_circumnavigation sweeps there and back, beside obstacles first",
  rrt_star: "rrt_star drives the shortest route that it found", rrt_star_ett: "rrt_star_ett drives the route of least expected time that it found",
  ett_exact: "ett_exact drives the route of least expected time", scout_route: "scout_route flies along the rover's route",
  rrt_star_it: "rrt_star_it flies where the speed of the ground is most uncertain", scout_value: "scout_value flies where knowing the ground would save the rover most time",
  scout_ahead: "scout_ahead flies over the unseen part of the hopper's cheapest way",
};

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
    const hop = history.hopperHopBefore(at);
    if (hop) return { cell: hop.from, decision: hop.decision, hop };
    return { cell: history.pose(at).cell, decision: at, hop: null };
  }

  /** The planner that decided, or that is to. */
  planner({ hop, decision }) {
    return hop ? this.history.plannerThatChose(hop) : this.history.plannerOf(0, decision) ?? this.history.plannerAt(decision);
  }

  /** The answer that is there; another is asked for if the policy has moved on and nobody waits for one. */
  answer(subject) {
    const { cell, decision } = subject;
    const decider = this.planner(subject);
    const key = `${cell}:${decision}`;
    const known = this.answers.get(key);
    const { history } = this;
    const policy = history.policy?.decision ?? -1;
    // An answer with the policy of its own decision is final, unless another planner has taken over since.
    const isFinal = known && known.decider === decider && (known.reason?.policy?.decision === decision || known.policy === policy && known.seen === history.seen);
    const now = performance.now();
    // Only of a hopper that goes alone, or with helicopters, are there chances and values.
    if (!isFinal && !this.asked && history.mission.hops && history.inside(cell)) {
      if (now - this.askedAt < PAUSE_MS) {
        clearTimeout(this.later);
        this.later = setTimeout(this.onChange, PAUSE_MS);
      } else {
        this.asked = key;
        this.askedAt = now;
        this.ask(cell, decision, key, { policy, seen: history.seen, decider });
      }
    }
    return known?.decider === decider ? this.ofDecider(known.reason, decider) : null;
  }

  /** An answer without the values of a planner that did not decide. */
  ofDecider(reason, decider) {
    const isOwn = !reason?.policy || !decider || reason.policy.planner === decider;
    return isOwn ? reason : { ...reason, policy: null, hops: reason.hops.map((hop) => ({ ...hop, value: null })) };
  }

  async ask(cell, decision, key, asked) {
    try {
      const reason = await askWhy(cell, decision);
      if (this.answers.size >= KEPT) this.answers.delete(this.answers.keys().next().value);
      this.answers.set(key, { reason, ...asked });
    } catch {
      this.answers.set(key, { reason: null, ...asked });
    }
    this.asked = null;
    this.onChange();
  }

  update(at) {
    const { history, root } = this;
    const subject = this.subject(at);
    const planner = this.planner(subject);
    const key = `${subject.cell} ${planner}`;
    const reason = this.answer(subject) ?? (this.last?.key === key ? this.last.reason : null);
    if (reason) {
      reason.decider = planner;
      this.last = { key, reason };
    }
    const act = !history.mission.hops && history.robots > 1 ? "decision" : "hop";
    const title = this.map.selected ? `Cell (${subject.cell.join(", ")})` : `${subject.hop ? "This" : "Next"} ${act}`;
    const way = subject.hop ? history.wayOf(subject.hop) : null;
    // While an answer is on its way the table before stays, dimmed, rather than an empty one.
    const isAwaited = !reason && history.mission.hops && (Boolean(this.asked) || history.inside(subject.cell) && !this.answers.has(`${subject.cell}:${subject.decision}`));
    const text = JSON.stringify([title, subject, reason, way, planner, isAwaited, this.map.options.policy, this.map.options.values]);
    if (this.shown === text) return;
    this.shown = text;
    root.querySelector("table").hidden = !history.mission.hops;
    root.querySelector("table").classList.toggle("awaited", isAwaited);
    root.querySelector("h2 > span").textContent = title;
    root.querySelector("#why-number").textContent = this.map.selected ? "Esc: back to the hop" : subject.hop ? `${history.decisionWord} ${subject.hop.decision}` : "";
    root.querySelector("p").textContent = this.sentence(subject, reason);
    // The rule of a planner without values is known before the answer comes.
    const note = isAwaited ? { text: RULES[planner] ?? "" } : this.note(subject, reason, planner);
    root.querySelector("#why-note").textContent = note.text;
    root.querySelector("#why-note").className = note.isStale ? "note warn" : "note";
    if (!isAwaited) this.fill(subject, reason, planner);
    this.fillWay(subject, way);
  }

  /** What became of a hop whose motion is physical: told and not believed. */
  fillWay({ hop }, way) {
    const list = this.root.querySelector("#why-way");
    // Once a hop of the mission has a way, the list keeps its place.
    list.hidden = this.history.ways.size === 0;
    list.style.visibility = way?.launch ? "visible" : "hidden";
    if (!way?.launch) return;
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
    if (!this.history.mission.hops) return hop ? this.deed(hop) : this.ground(cell);
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

  /** What one of several robots did. */
  deed(hop) {
    const { history } = this;
    const { body } = history.mission.robots[hop.robot];
    const name = `Robot ${hop.robot}, a ${body === "driver" ? "rover" : body},`;
    const lengthM = history.mission.grid.cell_size_m * Math.hypot(hop.to[0] - hop.from[0], hop.to[1] - hop.from[1]);
    if (hop.branch === "stranded") return `${name} is stranded at (${hop.to.join(", ")}).`;
    if (hop.origin !== "planner") return `${name} had no command in time: the fallback acted (${hop.origin}).`;
    if (body === "hopper") return `${name} hopped: ${this.outcome(hop, actionOf(history.aimOf(hop)), null)}`;
    if (lengthM === 0) return `${name} stayed where it was.`;
    const way = `${lengthM < 9.95 ? lengthM.toFixed(1) : lengthM.toFixed(0)} m to (${hop.to.join(", ")})`;
    const route = history.routeOf(hop.robot, hop.decision);
    const along = route ? `, on the route that it announced at decision ${route.decision}` : "";
    if (body === "helicopter") return `${name} flew ${way}${along}.`;
    const stopped = hop.branch === "halted" ? " Then the time of the stage was used up." : "";
    if (body === "driver") return `${name} drove ${way}${along}.${stopped}`;
    const entered = history.visitsUntil(hop.decision + 1)[hop.to[1] * history.width + hop.to[0]];
    return `${name} drove ${way}, ${entered > 1 ? `a cell that had been entered ${entered === 2 ? "once" : `${entered - 1} times`} before` : "a cell that nobody had entered"}.`;
  }

  /** What is known of the ground of a cell, where nobody is asked why. */
  ground([x, y]) {
    const { history } = this;
    const index = y * history.width + x;
    if (!history.inside([x, y])) return "Off the map.";
    if (history.seenAt[index] > this.map.shownAt) return "Nobody has seen this cell.";
    return history.flags[index] & 2 ? "Impassable ground." : "Passable ground.";
  }

  outcome(hop, chosen, reason) {
    const hops = reason?.hops.find((one) => one.action === chosen);
    // By the law nothing comes to rest elsewhere or is lost, so the planner gave that no chance.
    const chance = (n) => (!hops ? "" : hops.chances[n] === 0 ? ", which the planner gave no chance" : `, a chance of ${percent(hops.chances[n])} %`);
    const name = chosen ? ACTIONS[chosen][0].toUpperCase() + ACTIONS[chosen].slice(1) : "";
    const way = this.history.wayOf(hop);
    if (way && hop.branch !== "held") return this.told(hop, way, name, chance);
    switch (hop.branch) {
      case "intended": return `${name}, landed as aimed${chance(0)}.`;
      case "left": return `${name}, but it slipped to the left${chance(2)}.`;
      case "right": return `${name}, but it slipped to the right${chance(3)}.`;
      case "stayed": return "It got stuck and stayed where it was.";
      case "held": return "It held its place.";
      case "elsewhere": return `${name}, but it came to rest on another cell${chance(4)}.`;
      case "rolled_away": return `${name}, and it did not come to rest: it is lost${chance(5)}.`;
      case "halted": return "It stopped on its way: the time of the stage was used up.";
      default: return "";
    }
  }

  /** How a hop ended whose motion is physical, beside what was believed of it. */
  told(hop, way, name, chance) {
    const aimed = name ? `${name}: ` : "";
    const where = { intended: "on the cell it was aimed at", left: "on the cell to the left", right: "on the cell to the right", stayed: "on the cell it had left", elsewhere: "on another cell" }[hop.branch];
    const place = { intended: 0, stayed: 1, left: 2, right: 3, elsewhere: 4, rolled_away: 5 }[hop.branch];
    const ending = way.ended === "it came to rest" && where ? `it came to rest ${where}` : way.ended;
    return `${aimed}${ending}${place === undefined ? "" : chance(place)}.`.replace(/^./, (first) => first.toUpperCase());
  }

  /** What the chosen hop is worth beside the next best. */
  margin(chosen, reason) {
    const valued = (reason?.hops ?? []).map((hop) => ({ ...hop, value: this.worth(hop, reason) })).filter((hop) => hop.value !== null);
    const own = valued.find((hop) => hop.action === chosen);
    if (!own || valued.length < 2) return "";
    const other = valued.filter((hop) => hop !== own).reduce((best, hop) => (hop.value > best.value ? hop : best));
    if (own.value === Infinity || other.value === Infinity) return "";
    const more = own.value - other.value;
    const [mine, next] = [ACTIONS[own.action], ACTIONS[other.action]].map((word) => word);
    if (Math.abs(more) < 1e-6) return `${mine[0].toUpperCase()}${mine.slice(1)} and ${next} are worth the same.`;
    if (more > 0) return `${mine[0].toUpperCase()}${mine.slice(1)} is worth ${difference(more)} more than ${next}, the next best.`;
    return `${next[0].toUpperCase()}${next.slice(1)} is worth ${difference(-more)} more under the policy shown.`;
  }

  /** What a hop is worth to the planner that decided: its value, or for greedy its payoff; null without either. */
  worth(hop, reason) {
    if (reason.decider !== "greedy" || hop.value !== null) return hop.value;
    // The goal pays more than any other landing.
    if (hop.ends === "goal") return Infinity;
    return hop.terms ? hop.terms.reduce((sum, term) => sum + term, 0) : null;
  }

  note({ decision, hop }, reason, planner) {
    if (RULES[planner] && (!reason || !reason.policy)) return { text: RULES[planner] };
    if (!this.history.mission.hops) return { text: hop ? "" : "in this mission the decisions of robots are explained, not cells" };
    if (!reason) return { text: "" };
    if (!reason.policy) {
      if (reason.hops.some((one) => one.value !== null)) return { text: "" };
      const { policy, values } = this.map.options;
      if (!policy && !values) return { text: "no values: the policy is switched off (P)" };
      const isPast = !this.history.status?.tempo;
      return { text: `no values: ${isPast ? "a past mission has no policies" : `no policy of ${planner ?? "the planner in command"} has come`}` };
    }
    if (reason.hops.every((hop) => hop.value === null)) return { text: "no values here: the goal, off the hop lattice, or treasures are planned for" };
    const age = Math.abs(decision - reason.policy.decision);
    return age === 0 ? { text: "" } : { text: `values of ${reason.policy.planner} at hop ${reason.policy.decision}${age > STALE_HOPS ? `, ${age} hops away` : ""}`, isStale: age > STALE_HOPS };
  }

  fill({ hop }, reason, planner) {
    const isGreedy = planner === "greedy" && !reason?.policy;
    const heading = this.root.querySelector("thead th:last-child");
    heading.textContent = isGreedy ? "payoff" : "value";
    heading.title = isGreedy ? "safety + info + distance" : "Expected discounted payoff of the hop and all that follows";
    const chosen = hop ? actionOf(this.history.aimOf(hop)) : reason?.policy?.action;
    const vetoed = (hop ? hop.vetoed : reason?.vetoed) ?? "";
    const best = Math.max(...(reason?.hops ?? []).map((one) => this.worth(one, reason) ?? -Infinity));
    const cell = (text, className = "n") => Object.assign(document.createElement("td"), { textContent: text, className });
    this.root.querySelector("table").classList.toggle("by-table", (reason?.hops ?? []).some((one) => one.chances[4] + one.chances[5] > 0));
    const rows = (reason?.hops ?? []).map((one) => {
      const row = document.createElement("tr");
      row.className = [one.action === chosen ? "chosen" : "", vetoed.includes(one.action) ? "vetoed" : ""].join(" ").trim();
      const [aimed, stuck, left, right, elsewhere, lost] = one.chances;
      const name = Object.assign(document.createElement("th"), { textContent: `${ARROWS[one.action]} ${ACTIONS[one.action]}`, scope: "row" });
      row.append(name, cell(percent(aimed)), cell(percent(left)), cell(percent(right)), cell(percent(stuck)), cell(percent(elsewhere + lost), "n other"));
      if (one.terms) row.append(...one.terms.map((term) => cell(signed(term))));
      else row.append(Object.assign(cell(one.ends === "goal" ? "the goal" : one.ends ?? "", "n ends"), { colSpan: 3 }));
      const worth = this.worth(one, reason);
      row.append(cell(vetoed.includes(one.action) ? "vetoed" : worth === null || worth === Infinity ? "–" : signed(worth), `n value${worth === best ? " best" : ""}`));
      return row;
    });
    // Four rows whatever is known, so that nothing below jumps.
    while (rows.length < 4) {
      const row = document.createElement("tr");
      row.append(Object.assign(document.createElement("th"), { textContent: "–", scope: "row" }), Object.assign(cell("–"), { colSpan: 9 }));
      rows.push(row);
    }
    this.root.querySelector("tbody").replaceChildren(...rows);
  }
}
