// Where the time of decisions went: the last one, the history, the distribution, and the line of time.

import { TimeAxis, duration, fitted, tick } from "./scale.js";
import { colour } from "./theme.js";

const FONT = "10px system-ui, sans-serif";
const BINS_A_DECADE = 12;
const SWAP_SIZE = 5;
const LABEL_HEIGHT = 12;

function spans(axis, stages) {
  let sum = 0;
  return stages.map((us) => {
    const from = sum === 0 ? 0 : axis.at(sum);
    sum += us;
    return [from, axis.at(sum)];
  });
}

/** One decision: its stages as shares of it, and below on a scale of its own how much of the budget it took. */
export function drawBar(canvas, hop, names, budgetUs) {
  const { context, width, height } = fitted(canvas);
  const barHeight = 18;
  context.fillStyle = colour("raised");
  context.fillRect(0, 0, width, barHeight);
  context.font = FONT;
  context.textBaseline = "alphabetic";
  if (hop) {
    let sum = 0;
    hop.stages.forEach((us, n) => {
      const [from, until] = [(sum / hop.totalUs) * width, ((sum + us) / hop.totalUs) * width];
      sum += us;
      context.fillStyle = colour(names[n]);
      context.fillRect(from, 0, Math.max(until - from - 0.5, 0), barHeight);
      const text = `${Math.round((100 * us) / hop.totalUs)} %`;
      const room = context.measureText(text).width;
      if (until - from < room + 8) return;
      context.fillStyle = colour("ink");
      context.fillText(text, (from + until - room) / 2, 13);
    });
  }
  // The budget's scale: logarithmic, as decisions take from a hundredth of it to all of it.
  const axis = new TimeAxis(width - 2, Math.max(hop?.totalUs ?? 0, budgetUs), true);
  const [line, foot] = [barHeight + 12, height - 2];
  context.fillStyle = colour("edge");
  context.fillRect(0, line, width, 1);
  const isOver = hop && hop.totalUs > budgetUs;
  if (hop) {
    context.fillStyle = colour(isOver ? "bad" : "good");
    context.fillRect(0, line - 1.5, axis.at(hop.totalUs), 4);
  }
  const budgetX = axis.at(budgetUs);
  context.fillStyle = colour("bad");
  context.fillRect(budgetX - 1, line - 6, 2, 13);
  const name = `budget ${tick(budgetUs)}`;
  const nameRoom = context.measureText(name).width;
  const nameX = Math.min(budgetX + 5, width - nameRoom);
  context.fillText(name, nameX > budgetX + 4 ? nameX : Math.max(budgetX - nameRoom - 5, 0), foot);
  const taken = [Math.min(nameX, Math.max(budgetX - nameRoom - 5, 0)) - 6, budgetX + nameRoom + 10];
  for (const us of axis.ticks()) {
    const x = Math.round(axis.at(us)) + 0.5;
    context.fillStyle = colour("edge");
    context.fillRect(x, line - 3, 1, 7);
    const text = tick(us);
    const room = context.measureText(text).width;
    const left = Math.min(Math.max(x - room / 2, 0), width - room);
    if (left + room > taken[0] && left < taken[1]) continue;
    context.fillStyle = colour("dim");
    context.fillText(text, left, foot);
  }
}

/** The last decisions, a column each, with the budget above, or told where it is beyond. */
export function drawHistory(canvas, history, at, budgetUs, names, logarithmic) {
  const { context, width, height } = fitted(canvas);
  const [gutter, foot] = [42, 4];
  const column = 4;
  const count = Math.floor((width - gutter) / column);
  const until = Math.min(Math.max(at - history.first, 0), history.hops.length);
  const hops = history.hops.slice(Math.max(until - count, 0), until);
  const longest = hops.reduce((most, hop) => Math.max(most, hop.totalUs), 0);
  const axis = new TimeAxis(height - foot - 8, longest, logarithmic);
  const floor = height - foot;
  context.font = FONT;
  context.textBaseline = "middle";
  let above = Infinity;
  for (const us of axis.ticks()) {
    const y = Math.round(floor - axis.at(us)) + 0.5;
    context.fillStyle = colour("edge");
    context.fillRect(gutter, y, width - gutter, 1);
    // A low chart has room for every other name.
    if (above - y < LABEL_HEIGHT) continue;
    above = y;
    context.fillStyle = colour("dim");
    const text = tick(us);
    context.fillText(text, gutter - 6 - context.measureText(text).width, Math.max(y, 6));
  }
  const changes = new Set(history.leaders.filter((leader) => !leader.first).map(({ from }) => from));
  hops.forEach((hop, n) => {
    const x = gutter + n * column;
    spans(axis, hop.stages).forEach(([from, upTo], stage) => {
      context.fillStyle = colour(names[stage]);
      context.fillRect(x, floor - upTo, column - 1, Math.max(upTo - from, upTo > from ? 0.6 : 0));
    });
    if (changes.has(hop.decision)) {
      context.fillStyle = colour("text");
      context.fillRect(x - 1, 0, 1, floor);
    }
  });
  context.fillStyle = colour("bad");
  if (axis.holds(budgetUs)) context.fillRect(gutter, Math.round(floor - axis.at(budgetUs)), width - gutter, 1.5);
  return hops.length;
}

/** Bins of durations a decade wide each cut in twelve, from 1 µs to 100 s; misses are told apart. */
export function drawHistogram(canvas, history, at, budgetUs) {
  const { context, width, height } = fitted(canvas);
  const bins = new Uint32Array(8 * BINS_A_DECADE);
  const until = Math.min(Math.max(at - history.first, 0), history.hops.length);
  const totals = new Float64Array(until);
  for (let n = 0; n < until; n += 1) {
    totals[n] = history.hops[n].totalUs;
    const bin = Math.floor(Math.log10(Math.max(totals[n], 1)) * BINS_A_DECADE);
    bins[Math.min(bin, bins.length - 1)] += 1;
  }
  totals.sort();
  const axis = new TimeAxis(width - 2, budgetUs, true);
  const floor = height - 13;
  const most = bins.reduce((a, b) => Math.max(a, b), 1);
  bins.forEach((count, n) => {
    if (count === 0) return;
    const [from, upTo] = [10 ** (n / BINS_A_DECADE), 10 ** ((n + 1) / BINS_A_DECADE)];
    const [left, right] = [axis.at(from), axis.at(upTo)];
    // The share's root: one miss among thousands shall be seen.
    const tall = Math.max(Math.sqrt(count / most) * (floor - 10), 2);
    context.fillStyle = from >= budgetUs ? colour("bad") : colour("sense");
    context.fillRect(left, floor - tall, Math.max(right - left - 1, 1), tall);
  });
  context.font = FONT;
  context.textBaseline = "alphabetic";
  context.fillStyle = colour("edge");
  context.fillRect(0, floor, width, 1);
  for (const us of axis.ticks()) {
    const text = tick(us);
    const room = context.measureText(text).width;
    context.fillStyle = colour("dim");
    context.fillText(text, Math.min(Math.max(axis.at(us) - room / 2, 0), width - room), height - 2);
  }
  const quantile = (share) => totals[Math.min(Math.ceil(share * until), until) - 1] ?? 0;
  if (until > 0) {
    for (const [share, name] of [[0.5, "p50"], [0.99, "p99"]]) {
      const x = axis.at(quantile(share));
      context.fillStyle = colour("text");
      context.fillRect(x, 8, 1, floor - 8);
      context.fillText(name, Math.min(x + 3, width - 22), share === 0.5 ? 8 : 17);
    }
  }
  context.fillStyle = colour("bad");
  context.fillRect(axis.at(budgetUs), 4, 2, floor - 4);
  return { p50: quantile(0.5), p99: quantile(0.99), longest: totals[until - 1] ?? 0 };
}

/** The mission from its first hop to now: who commanded, what strayed, who came and went. */
export function drawLine(canvas, history, at) {
  const { context, width, height } = fitted(canvas);
  const { first, due } = history;
  // As wide as the thumb of the slider below leaves room for.
  const inset = 8;
  const x = (decision) => inset + ((decision - first) / Math.max(due - first, 1)) * (width - 2 * inset);
  const [top, thick] = [9, 8];
  context.fillStyle = colour("raised");
  context.fillRect(inset, top, width - 2 * inset, thick);
  // One colour for each planner of a single robot; of several robots all lead at once, and the line has one colour.
  const leaders = history.robots > 1 ? history.leaders.slice(0, 1) : history.leaders;
  leaders.forEach((leader, n) => {
    const until = leaders[n + 1]?.from ?? due;
    const from = Math.max(leader.from, first);
    if (until <= from) return;
    context.fillStyle = colour(`planner${history.plannerNumber(leader.planner)}`);
    context.fillRect(x(from), top, x(until) - x(from), thick);
  });
  const stray = new Set();
  history.hops.forEach((hop) => {
    if (hop.stray) stray.add(Math.round(x(hop.decision + 0.5)));
  });
  context.fillStyle = colour("stray");
  stray.forEach((place) => context.fillRect(place, top + thick + 1, 1.5, 4));
  history.leaders.forEach((leader) => {
    if (leader.first || leader.from < first) return;
    context.fillStyle = colour("text");
    context.beginPath();
    context.moveTo(x(leader.from), top);
    context.lineTo(x(leader.from) - SWAP_SIZE, top - SWAP_SIZE - 2);
    context.lineTo(x(leader.from) + SWAP_SIZE, top - SWAP_SIZE - 2);
    context.fill();
  });
  history.marks.forEach((mark) => {
    if (mark.change === "joined" && mark.decision === 0) return;
    if (mark.decision < first) return;
    context.fillStyle = colour(mark.change === "silent" ? "bad" : "good");
    context.beginPath();
    context.arc(x(Math.min(mark.decision, due)), 4, 3, 0, 2 * Math.PI);
    context.fill();
  });
  context.fillStyle = colour("text");
  context.fillRect(x(Math.min(at, due)) - 1, 0, 2, height);
}

export { duration };
