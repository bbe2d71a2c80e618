// The page's history of the mission, from the monitor's frames.

import { Way } from "./way.js";

export const UNSEEN = 0xffffffff;

/** Hops that are kept, as by the monitor; of a longer mission the last. */
const HOPS_KEPT = 65536;

/** Ways of hops that are kept, as by the monitor. */
const WAYS_KEPT = 16384;

/** The process that each stage waits for, and how long a stage lasts at least that has waited for a dead one, microseconds. */
const WAITS_FOR = { sense: "perception", map: "perception", deliver: "planner", plan: "planner", command: "planner", commit: "hopper-sim", state: "hopper-sim" };
const BLAME_US = 200_000;

/** The shortest action of one of several robots, as hopper-sim has it, seconds. */
const ACTION_MIN_S = 1;

const STRAY = new Set(["stayed", "left", "right", "elsewhere", "rolled_away"]);

/** Where a hop was aimed, in cells from its departure, by where it landed; null if it stayed or held. */
function aim(branch, dx, dy) {
  if (branch === "intended") return dx || dy ? [dx, dy] : null;
  // A slip to the left lands a quarter turn to the left of the aim.
  if (branch === "left") return [dy, 0 - dx];
  return branch === "right" ? [0 - dy, dx] : null;
}

/** One hop out of its row. */
function hop(row) {
  const [decision, branch, fromX, fromY, toX, toY, heightM, term, steps, status, treasures, visits, origin, vetoed, landedMs, robot, lastsS] = row;
  const stages = row.slice(17);
  const totalUs = stages.reduce((sum, us) => sum + us, 0);
  return {
    decision, branch, from: [fromX, fromY], to: [toX, toY], heightM, term, steps, status, treasures, visits, origin, vetoed, landedMs,
    robot, lastsS, stages, totalUs, stray: STRAY.has(branch), aim: aim(branch, toX - fromX, toY - fromY),
  };
}

export class MissionHistory {
  constructor() {
    this.mission = null;
    this.status = null;
    this.hops = [];
    this.first = 0;
    this.leaders = [];
    this.marks = [];
    this.collections = [];
    this.routes = [];
    this.ways = new Map();
    this.waysKnown = 0;
  }

  /** A mission begins, or this page begins to hear of it. */
  begin(mission) {
    const { width, height } = mission.grid;
    const cells = width * height;
    // Of one run, bounds stay: only the newest policy is told again.
    if (this.mission?.run !== mission.run) this.bounds = new Map();
    this.mission = mission;
    this.width = width;
    this.height = height;
    this.heights = new Float32Array(cells);
    this.flags = new Uint8Array(cells);
    this.seenAt = new Uint32Array(cells).fill(UNSEEN);
    /** Whether some seen cell is impassable. */
    this.hasBlocked = false;
    /** What was observed of each cell's speed: 0 nothing, 1 to 4 a speed, 5 to 8 a reading. */
    this.observed = mission.speeds ? new Uint8Array(cells) : null;
    /** What each layer with values of seen ground shows of each cell. */
    this.values = mission.layers.filter(({ of }) => of === "cells").map(() => new Float32Array(cells));
    this.speedRows = [];
    this.speedCodes = mission.speeds ? new Uint32Array(cells) : null;
    this.speedsKnown = 0;
    this.speedsFresh = false;
    this.routes = [];
    this.fresh = null;
    this.counted = null;
    this.timed = null;
    this.seen = 0;
    this.low = Infinity;
    this.high = -Infinity;
    this.hops = [];
    this.first = 0;
    this.leaders = [];
    this.marks = [];
    this.collections = [];
    /** What the motion model told of hops, by decision; and how often something was added. */
    this.ways = new Map();
    this.waysKnown = 0;
    this.policy = null;
    this.status = null;
  }

  addHops({ rows, leaders }) {
    for (const row of rows) {
      const next = hop(row);
      if (this.hops.length === 0 || next.decision !== this.due) {
        // Whoever fell behind what the monitor keeps goes on at what it has: hops are found by their number.
        this.hops = [];
        this.first = next.decision;
      }
      const before = this.hops.at(-1)?.treasures ?? (next.decision === 0 ? 0 : next.treasures);
      if (next.treasures > before) this.collections.push({ cell: next.to, decision: next.decision });
      this.hops.push(next);
    }
    if (this.hops.length > 1.25 * HOPS_KEPT) {
      const gone = this.hops.length - HOPS_KEPT;
      this.hops.splice(0, gone);
      this.first += gone;
    }
    this.leaders.push(...leaders);
    this.certify();
  }

  /** What the motion model told of hops. */
  addDetails({ rows, figures }) {
    for (const row of rows) {
      this.ways.set(row.decision, new Way(row, figures[row.detail.model], this.mission.grid.cell_size_m));
      if (this.ways.size > WAYS_KEPT) this.ways.delete(this.ways.keys().next().value);
    }
    this.waysKnown += rows.length;
  }

  /** The way of a hop; `null` where the motion model tells none. */
  wayOf(hop) {
    return (hop && this.ways.get(hop.decision)) ?? null;
  }

  /** Where a hop was aimed, in cells from its departure: by where it landed, or else by how it was launched; null if that tells nothing. */
  aimOf(hop) {
    if (!hop) return null;
    const step = this.wayOf(hop)?.step;
    const cells = this.mission.grid.hop_cells;
    return step ? step.map((one) => one * cells) : hop.aim;
  }

  /** Where robot 0 rests at a moment, in cells from the south-western corner: exactly where that is told, else the middle of its cell. */
  place(at) {
    const [x, y] = this.pose(at).cell;
    const way = this.wayOf(this.hopperHopBefore(at));
    return way && this.inside([x, y]) ? way.rest : [x + 0.5, y + 0.5];
  }

  /** Expected speeds of the next cells: new distributions, then pairs of a distribution's number and how many cells have it. */
  addSpeeds({ from, rows, runs }) {
    this.speedRows.push(...rows);
    let index = from;
    for (let n = 0; n < runs.length; n += 2) {
      this.speedCodes.fill(runs[n], index, index + runs[n + 1]);
      index += runs[n + 1];
    }
    this.speedsKnown = index;
    this.speedsFresh = true;
  }

  /** Whether expected speeds are new since it was asked for last. */
  takeFreshSpeeds() {
    const fresh = this.speedsFresh;
    this.speedsFresh = false;
    return fresh;
  }

  /** What a layer of speeds shows of a cell at a moment: under the prior (for a moment before all), or what was observed. */
  speed({ column }, index, at) {
    if (index >= this.speedsKnown) return null;
    const { certain } = this.mission;
    const row = this.speedRows[this.speedCodes[index]];
    const observed = this.seenAt[index] <= at ? this.observed[index] : 0;
    if (observed > 0 && observed <= 4) return certain[observed - 1][column];
    const columns = certain[0].length;
    const place = observed > 4 && row.length > columns ? columns * (observed - 4) : 0;
    return row[place + column];
  }

  /** What a layer with a scale shows of a cell at a moment; null where it shows nothing. */
  value(layer, index, at) {
    if (layer.of === "speeds") return this.speed(layer, index, at);
    return this.seenAt[index] <= at ? this.values[layer.column][index] : null;
  }

  /** A robot's route, its points in cells from the south-western corner. */
  addRoute({ decision, robot, points }) {
    const size = this.mission.grid.cell_size_m;
    this.routes.push({ decision, robot, points: points.map(([x, y]) => [x / size, y / size]) });
  }

  /** The route that a robot followed at a moment: that of its last announcement. */
  routeOf(robot, at) {
    let last = null;
    for (const route of this.routes) {
      if (route.robot === robot && route.decision < at && (!last || route.decision > last.decision)) last = route;
    }
    // A helicopter whose rover's stage has ended is with it again, and has no route.
    const isRecalled = last && this.mission.robots[robot].body === "helicopter" && this.hops.slice(Math.max(last.decision - this.first, 0), Math.max(at - this.first, 0)).some(({ branch }) => branch === "halted");
    return isRecalled ? null : last;
  }

  /** How far a robot's camera sees to each side, in cells; null without a camera. */
  viewCells(robot) {
    // A sensor is an object with one member, its kind; of all kinds cameras alone have a radius.
    const [{ radius_m = null }] = Object.values(this.mission.robots[robot].sensor);
    return radius_m && radius_m / this.mission.grid.cell_size_m;
  }

  addCells({ i, h, at, v, values = [] }) {
    let [index, date] = [0, 0];
    let { left, right, bottom, top } = this.fresh ?? { left: Infinity, right: -1, bottom: Infinity, top: -1 };
    for (let n = 0; n < i.length; n += 1) {
      index += i[n];
      date += at[n];
      if (this.seenAt[index] === UNSEEN) this.seen += 1;
      this.seenAt[index] = date;
      this.flags[index] = h[n] & 3;
      this.hasBlocked ||= (h[n] & 2) > 0;
      if (v && this.observed) this.observed[index] = v[n];
      values.forEach((column, place) => { this.values[place][index] = column[n]; });
      const heightM = Math.floor(h[n] / 4) / 1e3;
      this.heights[index] = heightM;
      this.low = Math.min(this.low, heightM);
      this.high = Math.max(this.high, heightM);
      const x = index % this.width;
      const y = (index - x) / this.width;
      left = Math.min(left, x); right = Math.max(right, x);
      bottom = Math.min(bottom, y); top = Math.max(top, y);
    }
    this.fresh = { left, right, bottom, top };
  }

  /** The rectangle of cells that are new since it was asked for last. */
  takeFresh() {
    const fresh = this.fresh;
    this.fresh = null;
    return fresh;
  }

  /** The decision that is due. */
  get due() {
    return this.first + this.hops.length;
  }

  /** The hop that led to the moment `at`. */
  hopBefore(at) {
    return this.hops[at - this.first - 1] ?? null;
  }

  /** The last hops before a moment, `most` at most. */
  hopsUntil(at, most = Infinity) {
    const until = Math.min(Math.max(at - this.first, 0), this.hops.length);
    return this.hops.slice(Math.max(until - most, 0), until);
  }

  /** Number of robots of the mission. */
  get robots() {
    return this.mission?.robots.length ?? 1;
  }

  /** Whether the mission was over at a moment. */
  isOver(at) {
    const before = this.hopBefore(at);
    return Boolean(before) && before.status !== "underway";
  }

  /** Where each robot stood at a moment, and how; without a cell as long as nobody has told. */
  poses(at) {
    const members = this.status?.progress?.robots ?? [];
    const isNow = at >= this.due;
    return Array.from({ length: this.robots }, (_, robot) => {
      const member = members[robot];
      const index = this.hops.slice(0, Math.max(at - this.first, 0)).findLastIndex((hop) => hop.robot === robot);
      const rest = this.wayOf(this.hops[index])?.rest;
      if (isNow && member) return { cell: [member.at.cell.x, member.at.cell.y], rest, standing: member.standing };
      const later = this.hops.find((hop) => hop.robot === robot);
      const cell = index >= 0 ? this.hops[index].to : later ? later.from : member ? [member.at.cell.x, member.at.cell.y] : null;
      const acts = this.hops.some((hop) => hop.robot === robot && hop.decision >= at);
      return { cell, rest, standing: acts ? "active" : (member?.standing ?? "active") };
    });
  }

  /** Simulated time at a moment, seconds since the start: when the robot whose turn it is acts. At the end of the mission, the end of
   * the last action. */
  timeAt(at) {
    const members = this.status?.progress?.robots ?? [];
    if (at >= this.due && members.length > 0) {
      const due = this.turn(at);
      return (due < 0 ? Math.max(...members.map(({ ready_at_ns: readyNs }) => readyNs)) : members[due].ready_at_ns) / 1e9;
    }
    // Robots act in the order of their clocks; one that has waited goes on when another acts.
    const known = this.timed;
    if (!known || known.first !== this.first) this.timed = { first: this.first, starts: [], clocks: [] };
    const { starts, clocks } = this.timed;
    for (let n = starts.length; n < this.hops.length; n += 1) {
      const { robot, lastsS } = this.hops[n];
      starts.push(Math.max(clocks[robot] ?? 0, starts[n - 1] ?? 0));
      clocks[robot] = starts[n] + (this.robots > 1 && lastsS > 0 ? Math.max(lastsS, ACTION_MIN_S) : lastsS);
    }
    return starts[at - this.first] ?? clocks.reduce((latest, clock) => Math.max(latest, clock ?? 0), 0);
  }

  /** Whose turn it is at a moment: of the active robots that wait for no other the one with the least clock and number. */
  turn(at) {
    if (at < this.due) return this.hops[at - this.first]?.robot ?? -1;
    if (this.isOver(at)) return -1;
    const members = this.status?.progress?.robots ?? [];
    let due = -1;
    members.forEach((member, robot) => {
      if (member.standing === "active" && !member.waits && (due < 0 || member.ready_at_ns < members[due].ready_at_ns)) due = robot;
    });
    return due;
  }

  /** How often robots had entered each cell by a moment, starts included. */
  visitsUntil(at) {
    const known = this.counted;
    if (!known || known.at > at || known.first !== this.first) {
      this.counted = { at: this.first, first: this.first, visits: new Uint16Array(this.width * this.height), started: new Set() };
    }
    const { visits, started } = this.counted;
    const enter = ([x, y]) => { visits[y * this.width + x] += 1; };
    for (let n = this.counted.at - this.first; n < this.hops.length && n < at - this.first; n += 1) {
      const hop = this.hops[n];
      if (!started.has(hop.robot)) {
        started.add(hop.robot);
        enter(hop.from);
      }
      if (hop.branch !== "held" && hop.branch !== "stranded" && (hop.from[0] !== hop.to[0] || hop.from[1] !== hop.to[1])) enter(hop.to);
    }
    this.counted.at = Math.min(at, this.due);
    return visits;
  }

  /** The last decision before a moment; in a hopper's mission with helicopters, the hopper's. */
  hopperHopBefore(at) {
    if (!this.mission.hops || this.robots === 1) return this.hopBefore(at);
    for (let moment = at; moment > this.first; moment -= 1) {
      const hop = this.hopBefore(moment);
      if (hop?.robot === 0) return hop;
    }
    return undefined;
  }

  /** Where the hopper stands at a moment. */
  pose(at) {
    const before = this.hopperHopBefore(at);
    if (before) return { cell: before.to, heightM: before.heightM };
    const cell = this.mission.hops && this.robots > 1 ? this.mission.start : this.hops[0]?.from ?? this.mission.start;
    const [x, y] = cell;
    return { cell, heightM: this.heights[y * this.width + x] ?? 0 };
  }

  /** Goals visited by a moment. */
  visits(at) {
    return this.hopBefore(at)?.visits ?? 0;
  }

  /** Where in the hops the route at a moment begins: of visits in turn it has the leg under way and the one before. */
  routeFrom(at) {
    const visits = this.visits(at);
    let [low, high] = [0, this.hops.length];
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.hops[middle].visits + 2 <= visits) low = middle + 1; else high = middle;
    }
    return low;
  }

  /** The goal of robot 0 in force at a moment, the first again after the last; null if it has no place to go to. */
  goal(at) {
    const { goals } = this.mission;
    return goals[this.visits(at) % goals.length] ?? null;
  }

  /** Treasures that had been seen at a moment, and not been collected. */
  treasures(at) {
    const taken = ([x, y]) => this.collections.find(({ cell }) => cell[0] === x && cell[1] === y);
    const lying = (this.status?.treasures ?? []).filter((cell) => !taken(cell));
    const later = this.collections.filter(({ decision }) => decision >= at).map(({ cell }) => cell);
    return [...lying, ...later].filter(([x, y]) => this.seenAt[y * this.width + x] <= at);
  }

  /** A policy came: the newest for the eye, its bound for the term that it was made under. */
  addPolicy(policy) {
    this.policy = policy;
    this.certify();
  }

  certify() {
    const { policy } = this;
    // Only a hopper has a policy, and it is robot 0.
    const leader = policy && this.leaders.findLast((one) => one.robot === 0 && one.from <= policy.decision);
    if (leader && leader.planner === policy.planner) this.bounds.set(leader.term, policy.error_bound);
  }

  /** Sensing radius of the hopper in cells at a height, P23 section IV. */
  radiusCells(heightM) {
    const { gain, offset_m: offset, radius_min_m: min, radius_max_m: max } = this.mission.robots[0].sensor.disc;
    return Math.min(Math.max(gain * (heightM + offset), min), max) / this.mission.grid.cell_size_m;
  }

  /** The leader of the robot that acted last before a moment; `null` before anybody did. */
  leaderAt(at) {
    const hop = this.hopBefore(at);
    const [robot, term] = hop ? [hop.robot, hop.term] : [0, this.status?.state?.term];
    return this.leaders.find((leader) => leader.robot === robot && leader.term === term) ?? null;
  }

  /** The planner that decided last before a moment. */
  plannerAt(at) {
    return this.leaderAt(at)?.planner ?? this.policy?.planner ?? null;
  }

  /** Who commanded `robot` last before a moment. */
  plannerOf(robot, at) {
    const leader = this.leaders.findLast((one) => one.robot === robot && one.from < at);
    return leader?.planner ?? this.status?.progress?.robots?.[robot]?.leader?.planner ?? null;
  }

  /** The planner that chose a hop. */
  plannerThatChose({ robot, term }) {
    return this.leaders.find((leader) => leader.robot === robot && leader.term === term)?.planner ?? null;
  }

  /** How many decisions a leader took in its term until a moment, of those that are known. */
  commands({ robot, from }, at) {
    const next = this.leaders.find((one) => one.robot === robot && one.from > from)?.from ?? this.due;
    const until = Math.min(next, at);
    if (this.robots === 1) return Math.max(until - from, 0);
    return this.hops.filter((hop) => hop.robot === robot && hop.decision >= from && hop.decision < until).length;
  }

  /** The stage of a hop that waited for a process which was dead, and for which; null if none did. */
  blame({ decision, robot, stages, totalUs }) {
    const longest = stages.reduce((most, us, n) => (us > stages[most] ? n : most), 0);
    if (stages[longest] < BLAME_US || stages[longest] < totalUs / 2) return null;
    const stage = this.mission.stages[longest];
    const role = WAITS_FOR[stage];
    // It fell silent, or another took its place before it could.
    const isOfRole = (mark) => mark.decision === decision && mark.role === role;
    const took = this.leaders.find((leader) => leader.robot === robot && leader.from === decision && !leader.first);
    const gone = this.marks.find((mark) => isOfRole(mark) && mark.change === "silent");
    const name = (mark) => `${mark.planner ? `${mark.role} ${mark.planner}` : mark.role} (${mark.pid})`;
    if (gone) return { stage, text: `${stage} waited for ${name(gone)}, which fell silent` };
    const come = decision > 0 && this.marks.find((mark) => isOfRole(mark) && mark.change !== "silent");
    if (role === "planner" && took) return { stage, text: `${stage} waited until planner ${took.planner} (${took.pid || "–"}) took command` };
    return come && role !== "planner" ? { stage, text: `${stage} waited until ${name(come)} was there` } : null;
  }

  /** What a decision is called: robots of a team do not all hop. */
  get decisionWord() {
    return this.robots > 1 ? "decision" : "hop";
  }

  /** Which of several robots something is about, as the beginning of a line. */
  robotPrefix(robot) {
    return this.robots > 1 ? `robot ${robot}: ` : "";
  }

  /** A number for each algorithm in the order of its first command. */
  plannerNumber(planner) {
    const names = [...new Set(this.leaders.map((leader) => leader.planner))];
    return Math.max(names.indexOf(planner), 0) % 6;
  }

  inside([x, y]) {
    return x >= 0 && y >= 0 && x < this.width && y < this.height;
  }
}
