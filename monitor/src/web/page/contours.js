// Contour lines of the ground that was seen: marching squares between the middles of cells.

/** Steps between two lines, metres. */
const STEPS_M = [0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500];

/** The lines over a part of the map as it was seen by decision `until`: a path in cells from the upper left, and the step. */
export function contours(history, { left, right, bottom, top }, [low, high], until) {
  const stepM = STEPS_M.find((step) => (high - low) / step <= 10) ?? 1000;
  const { width, height, heights, seenAt } = history;
  const path = new Path2D();
  for (let y = bottom; y < Math.min(top, height - 1); y += 1) {
    for (let x = left; x < Math.min(right, width - 1); x += 1) {
      const index = y * width + x;
      const [sw, se, nw, ne] = [index, index + 1, index + width, index + width + 1];
      if (seenAt[sw] > until || seenAt[se] > until || seenAt[nw] > until || seenAt[ne] > until) continue;
      const [a, b, c, d] = [heights[sw], heights[se], heights[ne], heights[nw]];
      const [least, most] = [Math.min(a, b, c, d), Math.max(a, b, c, d)];
      for (let level = Math.ceil(least / stepM) * stepM; level < most; level += stepM) {
        segment(path, x + 0.5, height - 0.5 - y, [a, b, c, d], level);
      }
    }
  }
  return { path, stepM };
}

/** One square's lines: corners south-west, south-east, north-east, north-west; (x, y) is the south-western, y downwards. */
function segment(path, x, y, corners, level) {
  const spots = [];
  const places = [[0, 0], [1, 0], [1, -1], [0, -1]];
  for (let n = 0; n < 4; n += 1) {
    const [from, to] = [corners[n], corners[(n + 1) % 4]];
    if ((from < level) === (to < level)) continue;
    const share = (level - from) / (to - from);
    const [p, q] = [places[n], places[(n + 1) % 4]];
    spots.push([x + p[0] + (q[0] - p[0]) * share, y + p[1] + (q[1] - p[1]) * share]);
  }
  for (let n = 0; n + 1 < spots.length; n += 2) {
    path.moveTo(...spots[n]);
    path.lineTo(...spots[n + 1]);
  }
}
