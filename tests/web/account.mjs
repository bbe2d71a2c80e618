// Holds the page's account to what it promises of hops and treasures; ends with an error where it does not.
//
// node account.mjs ACCOUNT, where ACCOUNT is the page's module.

import assert from "node:assert/strict";
import { readFile } from "node:fs/promises";

const text = await readFile(process.argv[2], "utf8");
const { Account } = await import(`data:text/javascript,${encodeURIComponent(text)}`);

const account = new Account();
account.begin({ run: "1", grid: { width: 100, height: 1 }, start: [0, 0], goals: [[99, 0]] });

/** A hop east that lands with so many treasures. */
const row = (decision, treasures) => [decision, "intended", decision, 0, decision + 1, 0, 0, 1, decision, "underway", treasures, 0, "planner", "", 0, 1, 1, 1, 1, 1, 1, 1];
const rows = (from, until, treasures) => Array.from({ length: until - from }, (_, n) => row(from + n, treasures(from + n)));

// One treasure on cell 3, collected by hop 2, and one on cell 9 that lies there still.
account.addHops({ rows: rows(0, 6, (decision) => (decision < 2 ? 0 : 1)), reigns: [] });
account.addCells({ i: [3, 6], h: [0, 0], at: [1, 3] });
account.status = { treasures: [[9, 0]] };
assert.deepEqual(account.treasures(0), [], "neither was seen");
assert.deepEqual(account.treasures(2), [[3, 0]]);
assert.deepEqual(account.treasures(3), [], "collected");
assert.deepEqual(account.treasures(account.due), [[9, 0]]);

// The monitor skips ahead.
account.addHops({ rows: rows(6, 8, () => 1), reigns: [] });
account.addHops({ rows: rows(50, 55, () => 4), reigns: [] });
assert.deepEqual([account.first, account.due], [50, 55]);
assert.deepEqual(account.pose(53).cell, [53, 0]);
assert.equal(account.hopBefore(8), null, "it is no longer kept");
assert.deepEqual(account.treasures(51), [[9, 0]], "where the others lay nobody told");
