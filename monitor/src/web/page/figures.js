// The figures beside the map: what a hopper, a team or robots on uncertain ground have come to.

import { fixed } from "./scale.js";

/** The figures of a hopper: names, values and units; of several robots those that are robot 0's also say so. */
function hopperFigures(history, at, isLive) {
  const { mission, status } = history;
  const progress = status?.progress;
  const pose = history.pose(at);
  const hop = history.hopperHopBefore(at);
  const size = mission.grid.cell_size_m;
  const goal = history.goal(at);
  const distance = Math.hypot(pose.cell[0] - goal[0], pose.cell[1] - goal[1]) * size;
  const hops = history.hopsUntil(at).filter(({ robot }) => robot === 0);
  const stray = hops.filter((one) => one.stray).length;
  let seen = history.seen;
  if (!isLive) {
    seen = 0;
    for (const first of history.seenAt) seen += first <= at ? 1 : 0;
  }
  const share = (100 * seen) / (history.width * history.height);
  const own = history.robots > 1 ? [0] : [];
  return [
    ["hops", `${history.robots > 1 ? hops.length : at}`, "", own],
    mission.hops_max === null ? ["step", `${hop?.steps ?? 0}`, `/${mission.steps_max}`, own] : ["visited", `${history.visits(at)}`, "goals", own],
    ["to goal", distance.toFixed(1), "m", own],
    ["seen", share < 9.95 ? share.toFixed(1) : share.toFixed(0), "%"],
    ["height", fixed(pose.heightM, 2), "m", own],
    ["sensing", (history.radiusCells(pose.heightM) * size).toFixed(1), "m", own],
    ["stray", `${stray + (isLive && progress ? Math.max(progress.stray_hops - stray, 0) : 0)}`, "", own],
    ["treasures", `${hop?.treasures ?? 0}`, "", own],
  ];
}

/** The figures of robots that cover ground. */
function teamFigures(history, at, isLive) {
  const visits = history.visitsUntil(at);
  let [covered, entered] = [0, 0];
  for (const count of visits) {
    covered += count > 0 ? 1 : 0;
    entered += count;
  }
  const share = (100 * (isLive ? history.seen : history.seenAt.filter((first) => first <= at).length)) / (history.width * history.height);
  const active = history.poses(at).filter(({ standing }) => standing === "active").length;
  const due = history.turn(at);
  return [
    ["decisions", `${at}`, ""], ["step", `${history.hopBefore(at)?.steps ?? 0}`, `/${history.mission.steps_max}`], ["covered", `${covered}`, "cells"], ["seen", share.toFixed(0), "%"],
    ["visits", `${entered}`, ""], ["again", entered ? ((100 * (entered - covered)) / entered).toFixed(0) : "0", "%"],
    ["active", `${active}`, `/${history.robots}`], ["turn", due < 0 ? "–" : `robot ${due}`, "", due < 0 ? [] : [due]],
  ];
}

/** How far a robot is from its last goal at its cell, metres; null without a goal or a cell. */
export function toGoalM(history, robot, cell) {
  const goal = history.mission.robots[robot]?.goals.at(-1);
  return goal && cell ? history.mission.grid.cell_size_m * Math.hypot(goal[0] - cell[0] - 0.5, goal[1] - cell[1] - 0.5) : null;
}

/** The figures of robots on uncertain ground: `to goal` is of the first that drives. */
function driveFigures(history, at, isLive) {
  const { grid: { cell_size_m: size }, robots } = history.mission;
  const moved = { driver: 0, helicopter: 0 };
  for (let n = 0; n < at - history.first && n < history.hops.length; n += 1) {
    const { robot, from, to } = history.hops[n];
    const { body } = robots[robot];
    if (body in moved) moved[body] += Math.hypot(to[0] - from[0], to[1] - from[1]) * size;
  }
  const all = (wanted) => robots.flatMap(({ body }, robot) => (body === wanted ? [robot] : []));
  const driver = all("driver").slice(0, 1);
  const toGoal = toGoalM(history, driver[0], history.poses(at)[driver[0]]?.cell);
  const byName = Object.fromEntries(teamFigures(history, at, isLive).map((figure) => [figure[0], figure]));
  return [
    byName.decisions, ["to goal", toGoal?.toFixed(0) ?? "–", "m", driver], ["driven", moved.driver.toFixed(0), "m", all("driver")],
    ["flown", moved.helicopter.toFixed(0), "m", all("helicopter")], byName.seen,
    ["routes", `${history.routes.filter(({ decision }) => decision < at).length}`, ""], byName.active, byName.turn,
  ];
}

/** The figures that suit the mission: names, values, units, and of which robots they are. `isLive`: at the newest moment. */
export function figuresOf(history, at, isLive) {
  const { speeds, hops } = history.mission;
  return (speeds ? driveFigures : hops ? hopperFigures : teamFigures)(history, at, isLive);
}
