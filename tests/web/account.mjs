// Checks hops and treasures of the page's mission history; exits with an error if one is wrong.
//
// node account.mjs HISTORY, where HISTORY is the page's module.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";

const text = await readFile(process.argv[2], "utf8");
const { MissionHistory } = await import(`data:text/javascript,${encodeURIComponent(text)}`);

const history = new MissionHistory();
history.begin({ run: "1", grid: { width: 100, height: 1 }, start: [0, 0], goals: [[99, 0]] });

/** A hop east that lands with so many treasures. */
const row = (decision, treasures) => [decision, "intended", decision, 0, decision + 1, 0, 0, 1, decision, "underway", treasures, 0, "planner", "", 0, 1, 1, 1, 1, 1, 1, 1];
const rows = (from, until, treasures) => Array.from({ length: until - from }, (_, n) => row(from + n, treasures(from + n)));

// One treasure on cell 3, collected by hop 2, and one on cell 9 that lies there still.
history.addHops({ rows: rows(0, 6, (decision) => (decision < 2 ? 0 : 1)), reigns: [] });
history.addCells({ i: [3, 6], h: [0, 0], at: [1, 3] });
history.status = { treasures: [[9, 0]] };
assert.deepEqual(history.treasures(0), [], "neither was seen");
assert.deepEqual(history.treasures(2), [[3, 0]]);
assert.deepEqual(history.treasures(3), [], "collected");
assert.deepEqual(history.treasures(history.due), [[9, 0]]);

// The monitor skips ahead.
history.addHops({ rows: rows(6, 8, () => 1), reigns: [] });
history.addHops({ rows: rows(50, 55, () => 4), reigns: [] });
assert.deepEqual([history.first, history.due], [50, 55]);
assert.deepEqual(history.pose(53).cell, [53, 0]);
assert.equal(history.hopBefore(8), null, "it is no longer kept");
assert.deepEqual(history.treasures(51), [[9, 0]], "where the others lay nobody told");
