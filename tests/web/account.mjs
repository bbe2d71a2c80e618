// Checks hops and treasures of the page's mission history; exits with an error if one is wrong.
//
// node account.mjs HISTORY, where HISTORY is the page's module.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";
import { dirname, join } from "node:path";

/** A module of the page with those that it imports, as an address: node takes files named .js for another kind. */
async function address(file) {
  let text = await readFile(file, "utf8");
  for (const [, name] of text.matchAll(/from "\.\/([\w.]+)"/g)) {
    text = text.replace(`"./${name}"`, JSON.stringify(await address(join(dirname(file), name))));
  }
  return `data:text/javascript,${encodeURIComponent(text)}`;
}

const { MissionHistory } = await import(await address(process.argv[2]));

const history = new MissionHistory();
history.begin({ run: "1", robots: [{}], grid: { width: 100, height: 1 }, start: [0, 0], goals: [[99, 0]], layers: [] });

/** A hop east that lands with so many treasures. */
const row = (decision, treasures) => [decision, "intended", decision, 0, decision + 1, 0, 0, 1, decision, "underway", treasures, 0, "planner", "", 0, 0, 1, 1, 1, 1, 1, 1, 1, 1];
const rows = (from, until, treasures) => Array.from({ length: until - from }, (_, n) => row(from + n, treasures(from + n)));

// One treasure on cell 3, collected by hop 2, and one on cell 9 that lies there still.
history.addHops({ rows: rows(0, 6, (decision) => (decision < 2 ? 0 : 1)), leaders: [] });
history.addCells({ i: [3, 6], h: [0, 0], at: [1, 3] });
history.status = { treasures: [[9, 0]] };
assert.deepEqual(history.treasures(0), [], "neither was seen");
assert.deepEqual(history.treasures(2), [[3, 0]]);
assert.deepEqual(history.treasures(3), [], "collected");
assert.deepEqual(history.treasures(history.due), [[9, 0]]);

// The monitor skips ahead.
history.addHops({ rows: rows(6, 8, () => 1), leaders: [] });
history.addHops({ rows: rows(50, 55, () => 4), leaders: [] });
assert.deepEqual([history.first, history.due], [50, 55]);
assert.deepEqual(history.pose(53).cell, [53, 0]);
assert.equal(history.hopBefore(8), null, "it is no longer kept");
assert.deepEqual(history.treasures(51), [[9, 0]], "where the others lay nobody told");

// Where hops were aimed follows from where they landed.
const aimed = (branch, x, y) => {
  const other = new MissionHistory();
  other.begin({ run: "2", robots: [{}], grid: { width: 9, height: 9 }, start: [4, 4], goals: [[8, 8]], layers: [] });
  other.addHops({ rows: [[0, branch, 4, 4, x, y, 0, 1, 1, "underway", 0, 0, "planner", "", 0, 0, 1, 1, 1, 1, 1, 1, 1, 1]], leaders: [] });
  return other.hops[0].aim;
};
assert.deepEqual(aimed("intended", 5, 4), [1, 0]);
assert.deepEqual(aimed("left", 4, 5), [1, 0], "aimed east, left of it is north");
assert.deepEqual(aimed("right", 4, 3).map((n) => n + 0), [1, 0], "aimed east, right of it is south");
assert.deepEqual(aimed("left", 3, 4).map((n) => n + 0), [0, 1], "aimed north, left of it is west");
assert.equal(aimed("stayed", 4, 4), null);

// Two robots in turn: where each stood, whose turn it was, and how often cells were entered.
const team = new MissionHistory();
team.begin({ run: "3", robots: [{}, {}], grid: { width: 9, height: 9 }, start: [0, 0], goals: [[8, 8]], layers: [] });
const step = (decision, robot, from, to, term = 1) => [decision, "intended", ...from, ...to, 0, term, 1, "underway", 0, 0, "planner", "", 0, robot, 1, 1, 1, 1, 1, 1, 1, 1];
team.addHops({ rows: [step(0, 0, [0, 0], [1, 0]), step(1, 1, [5, 5], [5, 6]), step(2, 0, [1, 0], [0, 0])], leaders: [] });
assert.deepEqual(team.poses(1).map(({ cell }) => cell), [[1, 0], [5, 5]]);
assert.deepEqual(team.poses(3).map(({ cell }) => cell), [[0, 0], [5, 6]]);
assert.deepEqual([team.turn(0), team.turn(1), team.turn(2)], [0, 1, 0]);
assert.equal(team.visitsUntil(3)[0], 2, "its start, and back again");

// Terms are counted for each robot: who commands which, how often, and until when.
const lead = (robot, term, planner, from, first) => ({ robot, term, planner, from, first, pid: 7 });
const leaders = [lead(0, 1, "spiral", 0, true), lead(1, 1, "cover_frontier", 1, true), lead(1, 2, "boustrophedon", 3, false)];
team.addHops({ rows: [step(3, 1, [5, 6], [5, 7], 2), step(4, 0, [0, 0], [0, 1])], leaders });
assert.deepEqual([1, 2, 3, 4, 5].map((at) => team.plannerAt(at)), ["spiral", "cover_frontier", "spiral", "boustrophedon", "spiral"]);
assert.deepEqual([3, 4].map((at) => team.plannerOf(1, at)), ["cover_frontier", "boustrophedon"]);
assert.deepEqual(leaders.map((leader) => team.commands(leader, 5)), [3, 1, 1]);
assert.deepEqual([team.decisionWord, team.robotPrefix(1), history.decisionWord, history.robotPrefix(0)], ["decision", "robot 1: ", "hop", ""]);
assert.equal(team.visitsUntil(1)[0], 1, "looking back");

// A stage that waited for a dead process names it.
const waits = new MissionHistory();
waits.begin({ run: "4", robots: [{}], grid: { width: 9, height: 9 }, start: [0, 0], goals: [[8, 8]], layers: [], stages: ["state", "sense", "map", "deliver", "plan", "command", "commit"] });
const timed = (decision, stages) => [decision, "held", 0, 0, 0, 0, 0, 1, 1, "underway", 0, 0, "planner", "", 0, 0, 0, ...stages];
waits.addHops({ rows: [timed(0, [1, 1, 1, 1, 1, 1, 1]), timed(1, [1, 900000, 1, 1, 1, 1, 1]), timed(2, [1, 1, 1, 1, 1200000, 1, 1]), timed(3, [1, 1, 1, 1, 800000, 1, 1])], leaders: [{ robot: 0, term: 1, from: 0, first: true, planner: "mdp", pid: 5 }, { robot: 0, term: 2, from: 2, first: false, planner: "greedy", pid: 9 }] });
waits.marks.push({ decision: 1, change: "silent", role: "perception", pid: 7, planner: "" });
assert.deepEqual(waits.hops.map((hop) => waits.blame(hop)?.text ?? null), [
  null, "sense waited for perception (7), which fell silent", "plan waited until planner greedy (9) took command", null,
]);

// Simulated time: each robot has a clock, and the one that is behind acts.
const clocks = new MissionHistory();
clocks.begin({ run: "5", robots: [{}, {}], grid: { width: 9, height: 9 }, start: [0, 0], goals: [], layers: [] });
const lasts = (decision, robot, seconds) => [decision, "intended", 0, 0, 1, 0, 0, 1, 1, "underway", 0, 0, "planner", "", 0, robot, seconds, 1, 1, 1, 1, 1, 1, 1];
clocks.addHops({ rows: [lasts(0, 0, 10), lasts(1, 1, 4), lasts(2, 1, 4), lasts(3, 1, 4)], leaders: [] });
assert.deepEqual([0, 1, 2, 3, 4].map((at) => clocks.timeAt(at)), [0, 0, 4, 8, 12]);
