// Which symbols and colours the legend names.

/** The keys of the legend that are shown: of what is drawn, and of nothing else. */
export function keysOf({ history, map, inSpace }, at) {
  const { mission, robots } = history;
  const [isTeam, isFlat, layer] = [robots > 1, !inSpace, map.shown()];
  const hopper = mission.robots.some(({ body }) => body === "hopper");
  const hasRoute = !isTeam || mission.hops;
  const near = isFlat && map.placed?.scale >= 4;
  const { policy } = map.options;
  const last = history.hopBefore(at);
  return {
    sand: hopper && layer.look !== "scale",
    blocked: layer.look !== "scale" && history.hasBlocked,
    visits: isFlat && layer.look === "entries",
    contours: isFlat && Boolean(map.lines) && history.high - history.low >= map.lines.stepM,
    start: !isTeam, goal: !isTeam && mission.goals.length > 0, hopper: !isTeam,
    owned: isTeam && mission.robots.some(({ goals }) => goals.length > 0), bodies: isTeam, turn: isFlat && isTeam && !history.isOver(at),
    route: !isTeam, travelled: isTeam, stray: hopper && (hasRoute || !isFlat), crosses: hasRoute && near && map.route.crosses.length > 0, stuck: hasRoute && near && map.route.stuck.length > 0,
    aim: isFlat && !isTeam && Boolean(last?.stray && history.aimOf(last)) && !history.isOver(at),
    sensing: isFlat && mission.hops, expected: policy && Boolean(map.policyAt(at)), policy: isFlat && policy && Boolean(map.policyAt(at)),
    treasure: isFlat && mission.hops && history.treasures(at).length > 0, collected: isFlat && mission.hops && history.collections.some(({ decision }) => decision < at),
    ways: history.ways.size > 0, routes: isFlat && history.routes.length > 0, sight: isFlat && mission.robots.some((_, robot) => history.viewCells(robot) !== null),
  };
}
