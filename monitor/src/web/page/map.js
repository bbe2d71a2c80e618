// The ground as it is discovered, with route, disc, policy, goal.

import { UNSEEN } from "./history.js";
import { fitted } from "./scale.js";
import { colour, isLight, isStark } from "./theme.js";

/** About as many cells are in sight while the hopper is followed from afar. */
const FOLLOWED_CELLS = 100;

/** An arrow takes as many pixels at least. */
const ARROW_ROOM = 12;

const ARROWS = { n: -Math.PI / 2, e: 0, s: Math.PI / 2, w: Math.PI };

// Heights from dusk to dust, even in lightness, told apart by colour-blind eyes.
const GROUND = [[43, 47, 66], [76, 70, 82], [117, 99, 97], [160, 134, 115], [199, 173, 141], [232, 214, 180]];
// Values of a policy, in the manner of viridis.
const VALUES = [[68, 1, 84], [65, 68, 135], [42, 120, 142], [34, 168, 132], [122, 209, 81], [253, 231, 37]];

function ramp(colours, share) {
  const place = Math.min(Math.max(share, 0), 1) * (colours.length - 1);
  const n = Math.min(Math.floor(place), colours.length - 2);
  return colours[n].map((low, band) => low + (colours[n + 1][band] - low) * (place - n));
}

const pixel = ([r, g, b]) => ((255 << 24) | (b << 16) | (g << 8) | r) >>> 0;

function rgb(hex) {
  const n = Number.parseInt(hex.slice(1, 7), 16);
  return [n >> 16, (n >> 8) & 255, n & 255];
}

export class MapView {
  constructor(canvas, history, onChange) {
    this.canvas = canvas;
    this.history = history;
    this.onChange = onChange;
    this.options = { policy: false, values: false, follow: false };
    this.zoom = 1;
    this.centre = null;
    this.pointer = null;
    this.listen();
  }

  begin() {
    const { width, height, mission } = this.history;
    this.layer = new OffscreenCanvas(width, height);
    this.layerContext = this.layer.getContext("2d");
    this.image = this.layerContext.createImageData(width, height);
    this.pixels = new Uint32Array(this.image.data.buffer);
    this.colours = new Uint32Array(width * height);
    this.shownAt = Infinity;
    this.range = this.ranged(mission.height_m);
    this.centre = null;
    this.zoom = 1;
    this.valueLayer = null;
    this.forgetRoute();
  }

  forgetRoute() {
    this.route = { path: new Path2D(), stray: new Path2D(), crosses: [], stuck: [], first: 0, from: 0, until: 0, at: -1 };
  }

  /** The range of heights that is shaded: that of what was seen, within a little of that of the brief. */
  ranged([low, high]) {
    return high > low ? [low, high] : [low, low + 1];
  }

  recolour() {
    if (!this.layer) return;
    this.paint({ left: 0, bottom: 0, right: this.history.width - 1, top: this.history.height - 1 });
    this.show(this.shownAt, true);
    this.valueLayer = null;
  }

  /** Takes over what is new in the history. */
  update(at) {
    const fresh = this.history.takeFresh();
    if (fresh) {
      const { low, high } = this.history;
      const [rangeLow, rangeHigh] = this.range;
      if (low < rangeLow || high > rangeHigh) {
        // The brief foresaw less: shade anew, with room for more.
        const room = 0.15 * (Math.max(high, rangeHigh) - Math.min(low, rangeLow));
        this.range = [Math.min(rangeLow, low - room), Math.max(rangeHigh, high + room)];
        this.paint({ left: 0, bottom: 0, right: this.history.width - 1, top: this.history.height - 1 });
        this.show(at, true);
      } else {
        const { width, height } = this.history;
        // Shading looks at neighbours.
        const area = {
          left: Math.max(fresh.left - 1, 0), right: Math.min(fresh.right + 1, width - 1),
          bottom: Math.max(fresh.bottom - 1, 0), top: Math.min(fresh.top + 1, height - 1),
        };
        this.paint(area);
        this.reveal(area, at);
      }
    }
    this.show(at);
  }

  /** Computes the colours of an area. */
  paint({ left, right, bottom, top }) {
    const { width, height, heights, flags, seenAt } = this.history;
    const [low, high] = this.range;
    const sand = rgb(colour("sand"));
    const relief = 1.6 / Math.max(this.history.mission.grid.cell_size_m, 1e-9);
    const gain = this.range[1] - this.range[0] < 4 ? 1.3 : 0.8;
    for (let y = bottom; y <= top; y += 1) {
      for (let x = left; x <= right; x += 1) {
        const index = y * width + x;
        if (seenAt[index] === UNSEEN) continue;
        const here = heights[index];
        const beside = (dx, dy) => {
          const [i, j] = [x + dx, y + dy];
          if (i < 0 || j < 0 || i >= width || j >= height) return here;
          const neighbour = j * width + i;
          return seenAt[neighbour] === UNSEEN ? here : heights[neighbour];
        };
        // Light from the north-west.
        const slope = (beside(1, 0) - beside(-1, 0) - beside(0, 1) + beside(0, -1)) * relief * gain;
        const light = 1 - 0.42 * Math.tanh(slope / 2);
        let shade = ramp(GROUND, (here - low) / (high - low)).map((band) => Math.min(band * light, 255));
        if (flags[index] & 1) shade = shade.map((band, n) => 0.45 * band + 0.55 * sand[n] * Math.min(light, 1.1));
        if (flags[index] & 2) shade = shade.map((band) => band * 0.35);
        this.colours[index] = pixel(shade);
      }
    }
  }

  /** Puts an area of what was seen at a moment on the layer. */
  reveal({ left, right, bottom, top }, at) {
    const { width, height, seenAt } = this.history;
    for (let y = bottom; y <= top; y += 1) {
      const row = (height - 1 - y) * width;
      for (let x = left; x <= right; x += 1) {
        const index = y * width + x;
        this.pixels[row + x] = seenAt[index] <= at ? this.colours[index] : 0;
      }
    }
    this.layerContext.putImageData(this.image, 0, 0, left, height - 1 - top, right - left + 1, top - bottom + 1);
  }

  show(at, anew = false) {
    if (at === this.shownAt && !anew) return;
    this.shownAt = at;
    this.reveal({ left: 0, bottom: 0, right: this.history.width - 1, top: this.history.height - 1 }, at);
  }

  /** Where the map lies on the canvas: its scale, and the corner of cell (0, 0)'s row from the top. */
  frame(width, height) {
    const { history } = this;
    const whole = Math.min((width - 16) / history.width, (height - 16) / history.height);
    const scale = whole * this.zoom;
    let [x, y] = [history.width / 2, history.height / 2];
    if (this.zoom > 1 && this.centre) {
      const [halfX, halfY] = [Math.min(width / scale / 2, x), Math.min(height / scale / 2, y)];
      x = Math.min(Math.max(this.centre[0], halfX), history.width - halfX);
      y = Math.min(Math.max(this.centre[1], halfY), history.height - halfY);
    }
    return { scale, left: width / 2 - x * scale, top: height / 2 - (history.height - y) * scale };
  }

  draw(at) {
    const { context, width, height } = fitted(this.canvas);
    if (!this.layer) return;
    const { history } = this;
    const pose = history.pose(at);
    if (this.options.follow) {
      this.zoom = Math.max(this.zoom, 1.5, Math.max(history.width, history.height) / FOLLOWED_CELLS);
      this.centre = [pose.cell[0] + 0.5, pose.cell[1] + 0.5];
    }
    const frame = this.frame(width, height);
    this.placed = frame;
    const { scale, left, top } = frame;
    const right = left + history.width * scale;
    const bottom = top + history.height * scale;
    context.save();
    context.beginPath();
    context.rect(left, top, right - left, bottom - top);
    context.fillStyle = this.hatch(context);
    context.fill();
    context.clip();
    context.imageSmoothingEnabled = scale < 1.5;
    context.drawImage(this.layer, left, top, right - left, bottom - top);
    const policy = this.policyAt(at);
    if (policy && this.options.values) this.drawValues(context, policy, frame);
    if (scale >= 14) this.drawGrid(context, frame, width, height);
    if (policy && this.options.policy) this.drawArrows(context, policy, frame, width, height, at);
    const disc = history.radiusCells(pose.heightM) * scale;
    const [x, y] = this.spot(pose.cell, frame);
    context.beginPath();
    context.arc(x, y, disc, 0, 2 * Math.PI);
    context.fillStyle = `${colour("disc")}1c`;
    context.fill();
    context.lineWidth = 1.5;
    context.setLineDash([5, 4]);
    context.strokeStyle = colour("disc");
    context.stroke();
    context.setLineDash([]);
    this.drawRoute(context, frame, at);
    context.restore();
    context.strokeStyle = colour("edge");
    context.lineWidth = 1;
    context.strokeRect(left - 0.5, top - 0.5, right - left + 1, bottom - top + 1);
    this.drawMarks(context, frame, at, [x, y], history.inside(pose.cell));
    this.drawScaleBar(context, scale, left, Math.min(bottom, height), Math.max(left, 0));
  }

  /** The policy, if the planner in command at a moment is the one that made it. */
  policyAt(at) {
    const { policy } = this.history;
    const wanted = this.options.policy || this.options.values;
    return wanted && policy && policy.planner === this.history.plannerAt(at) ? policy : null;
  }

  spot([x, y], { scale, left, top }) {
    return [left + (x + 0.5) * scale, top + (this.history.height - 0.5 - y) * scale];
  }

  hatch(context) {
    const key = `${colour("unseen")}${colour("hatch")}`;
    if (this.hatched?.key !== key) {
      const tile = new OffscreenCanvas(8, 8);
      const pen = tile.getContext("2d");
      pen.fillStyle = colour("unseen");
      pen.fillRect(0, 0, 8, 8);
      pen.strokeStyle = colour("hatch");
      pen.lineWidth = 1;
      for (const shift of [-8, 0, 8]) {
        pen.beginPath();
        pen.moveTo(shift, 8);
        pen.lineTo(shift + 8, 0);
        pen.stroke();
      }
      this.hatched = { key, tile };
    }
    return context.createPattern(this.hatched.tile, "repeat");
  }

  drawGrid(context, { scale, left, top }, width, height) {
    context.beginPath();
    for (let x = Math.max(0, Math.ceil(-left / scale)); x <= this.history.width && left + x * scale <= width; x += 1) {
      context.moveTo(left + x * scale, Math.max(top, 0));
      context.lineTo(left + x * scale, Math.min(top + this.history.height * scale, height));
    }
    for (let y = Math.max(0, Math.ceil(-top / scale)); y <= this.history.height && top + y * scale <= height; y += 1) {
      context.moveTo(Math.max(left, 0), top + y * scale);
      context.lineTo(Math.min(left + this.history.width * scale, width), top + y * scale);
    }
    context.strokeStyle = colour("grid");
    context.lineWidth = 1;
    context.stroke();
  }

  drawValues(context, policy, { scale, left, top }) {
    if (this.valueLayer?.policy !== policy) {
      const layer = new OffscreenCanvas(policy.width, policy.height);
      const pen = layer.getContext("2d");
      const image = pen.createImageData(policy.width, policy.height);
      const pixels = new Uint32Array(image.data.buffer);
      // Ranks, not values: a goal worth a hundred would leave everything else in one colour.
      const sorted = Float64Array.from(policy.values).sort();
      const rank = (value) => {
        let [low, high] = [0, sorted.length];
        while (low < high) {
          const middle = (low + high) >> 1;
          if (sorted[middle] < value) low = middle + 1; else high = middle;
        }
        return low / Math.max(sorted.length - 1, 1);
      };
      for (let n = 0; n < pixels.length; n += 1) {
        const [x, y] = [n % policy.width, Math.floor(n / policy.width)];
        pixels[(policy.height - 1 - y) * policy.width + x] = pixel(ramp(VALUES, rank(policy.values[n])));
      }
      pen.putImageData(image, 0, 0);
      this.valueLayer = { policy, layer };
    }
    context.globalAlpha = 0.62;
    const y = top + (this.history.height - policy.y - policy.height) * scale;
    context.drawImage(this.valueLayer.layer, left + policy.x * scale, y, policy.width * scale, policy.height * scale);
    context.globalAlpha = 1;
  }

  drawArrows(context, policy, frame, width, height, at) {
    const { scale } = frame;
    // From afar every other cell has an arrow, or every third: they shall be read.
    const stride = Math.ceil(ARROW_ROOM / scale);
    if (stride > 8) return;
    // Dark on what was seen, faint on what was not: the route shall stand out.
    const [arms, faint] = [new Path2D(), new Path2D()];
    const length = scale * stride * 0.24;
    for (let n = 0; n < policy.actions.length; n += 1) {
      const turn = ARROWS[policy.actions[n]];
      if (turn === undefined) continue;
      const cell = [policy.x + (n % policy.width), policy.y + Math.floor(n / policy.width)];
      if (cell[0] % stride || cell[1] % stride) continue;
      const [x, y] = this.spot(cell, frame);
      if (x < -scale || y < -scale || x > width + scale || y > height + scale) continue;
      const [c, s] = [Math.cos(turn) * length, Math.sin(turn) * length];
      const arrow = this.history.seenAt[cell[1] * this.history.width + cell[0]] <= at ? arms : faint;
      arrow.moveTo(x - c, y - s);
      arrow.lineTo(x + c, y + s);
      arrow.moveTo(x + 0.2 * c + 0.55 * s, y + 0.2 * s - 0.55 * c);
      arrow.lineTo(x + c, y + s);
      arrow.lineTo(x + 0.2 * c - 0.55 * s, y + 0.2 * s + 0.55 * c);
    }
    context.lineCap = "round";
    context.lineJoin = "round";
    context.lineWidth = Math.min(Math.max(scale * 0.05, 1), 2.5);
    context.strokeStyle = this.options.values ? "#ffffffd0" : isStark() ? "#000000" : "#1b130cb0";
    context.stroke(arms);
    context.strokeStyle = this.options.values ? "#ffffffa0" : colour("arrow");
    context.stroke(faint);
  }

  /** The route grows with the mission; it is made anew only when time goes back, or on a patrol with a visit. */
  routeUntil(at) {
    const { history } = this;
    const from = history.routeFrom(at);
    if (at < this.route.at || this.route.first !== history.first || this.route.from !== from) {
      this.forgetRoute();
      Object.assign(this.route, { first: history.first, from, until: from });
    }
    const { route } = this;
    const y = (cell) => history.height - 0.5 - cell[1];
    for (; route.until < history.hops.length && history.first + route.until < at; route.until += 1) {
      const hop = history.hops[route.until];
      if (hop.branch === "stayed") route.stuck.push(hop.from);
      if (hop.branch === "stayed" || hop.branch === "held") continue;
      const path = hop.stray ? route.stray : route.path;
      path.moveTo(hop.from[0] + 0.5, y(hop.from));
      path.lineTo(hop.to[0] + 0.5, y(hop.to));
      if (hop.stray) route.crosses.push(hop.to);
    }
    route.at = at;
    return route;
  }

  drawRoute(context, frame, at) {
    const route = this.routeUntil(at);
    const { scale, left, top } = frame;
    const trace = (path, stroke, width, dash) => {
      context.save();
      context.translate(left, top);
      context.scale(scale, scale);
      context.lineWidth = width / scale;
      context.lineCap = "round";
      context.strokeStyle = stroke;
      context.setLineDash(dash.map((length) => length / scale));
      context.stroke(path);
      context.restore();
    };
    const casing = `${isLight() ? "#ffffff" : "#000000"}${isStark() ? "" : isLight() ? "a0" : "90"}`;
    const thick = scale > 10 ? 3 : 1.8;
    trace(route.path, casing, thick + 3, []);
    trace(route.stray, casing, thick + 3, []);
    trace(route.path, colour("route"), thick, []);
    trace(route.stray, colour("stray"), thick, [1.4 * thick, 2 * thick]);
    const size = Math.min(Math.max(scale * 0.16, 2.5), 5);
    context.strokeStyle = colour("stray");
    context.lineWidth = 2;
    context.beginPath();
    for (const cell of scale < 4 ? [] : route.crosses) {
      const [x, y] = this.spot(cell, frame);
      context.moveTo(x - size, y - size); context.lineTo(x + size, y + size);
      context.moveTo(x + size, y - size); context.lineTo(x - size, y + size);
    }
    for (const cell of scale < 4 ? [] : route.stuck) {
      const [x, y] = this.spot(cell, frame);
      context.moveTo(x + 1.6 * size, y);
      context.arc(x, y, 1.6 * size, 0, 2 * Math.PI);
    }
    context.stroke();
  }

  drawMarks(context, frame, at, [x, y], inside) {
    const { history } = this;
    const size = Math.min(Math.max(frame.scale * 0.32, 6), 11);
    const outlined = (paint, fill) => {
      context.beginPath();
      paint();
      context.lineWidth = 3.5;
      context.strokeStyle = "#000000b0";
      context.stroke();
      context.lineWidth = 1.8;
      context.strokeStyle = "#ffffff";
      context.stroke();
      if (fill) {
        context.fillStyle = fill;
        context.fill();
      }
    };
    const [startX, startY] = this.spot(history.mission.start, frame);
    outlined(() => context.rect(startX - size * 0.6, startY - size * 0.6, size * 1.2, size * 1.2), null);
    const goal = history.goal(at);
    for (const other of history.mission.goals) {
      const [goalX, goalY] = this.spot(other, frame);
      outlined(() => {
        context.moveTo(goalX, goalY);
        context.lineTo(goalX, goalY - 2.2 * size);
        context.lineTo(goalX + 1.5 * size, goalY - 1.65 * size);
        context.lineTo(goalX, goalY - 1.1 * size);
      }, colour(other === goal ? "good" : "state"));
    }
    for (const treasure of history.treasures(at)) {
      const [cx, cy] = this.spot(treasure, frame);
      outlined(() => {
        for (let n = 0; n < 10; n += 1) {
          const [turn, reach] = [(n * Math.PI) / 5 - Math.PI / 2, n % 2 ? size * 0.42 : size];
          context.lineTo(cx + Math.cos(turn) * reach, cy + Math.sin(turn) * reach);
        }
        context.closePath();
      }, "#ffd447");
    }
    if (inside) outlined(() => context.arc(x, y, size * 0.72, 0, 2 * Math.PI), colour("accent"));
    else {
      context.fillStyle = colour("bad");
      context.fillText("off the map", Math.min(Math.max(x, 4), context.canvas.clientWidth - 70), Math.max(y, 14));
    }
  }

  drawScaleBar(context, scale, left, bottom, edge) {
    const metre = scale / this.history.mission.grid.cell_size_m;
    const lengthM = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000].find((m) => m * metre >= 50) ?? 1000;
    const [x, y] = [edge + 12, bottom - 12];
    context.font = "11px system-ui, sans-serif";
    const text = `${lengthM} m`;
    context.fillStyle = "#000000a8";
    context.fillRect(x - 6, y - 17, Math.max(lengthM * metre, context.measureText(text).width) + 12, 24);
    context.fillStyle = "#fff";
    context.fillText(text, x, y - 5);
    context.fillRect(x, y, lengthM * metre, 2);
  }

  /** The cell under a point of the canvas. */
  cellAt(x, y) {
    if (!this.placed) return null;
    const { scale, left, top } = this.placed;
    const cell = [Math.floor((x - left) / scale), Math.floor(this.history.height - (y - top) / scale)];
    return this.history.inside(cell) ? cell : null;
  }

  /** What the pointer is over, in words. */
  reading(at) {
    const cell = this.pointer && this.layer ? this.cellAt(...this.pointer) : null;
    if (!cell) return "";
    const { history } = this;
    const index = cell[1] * history.width + cell[0];
    const words = [`(${cell[0]}, ${cell[1]})`];
    if (history.seenAt[index] > at) words.push("unseen");
    else {
      words.push(`${history.heights[index].toFixed(2)} m`, history.flags[index] & 1 ? "sand" : "hard");
      if (history.flags[index] & 2) words.push("impassable");
      words.push(`seen at hop ${history.seenAt[index]}`);
    }
    const policy = this.policyAt(at);
    const [x, y] = policy ? [cell[0] - policy.x, cell[1] - policy.y] : [-1, -1];
    if (policy && x >= 0 && y >= 0 && x < policy.width && y < policy.height) {
      words.push(`value ${policy.values[y * policy.width + x].toFixed(2)}`);
    }
    return words.join(" · ");
  }

  turnTo(zoom, centre) {
    this.zoom = Math.min(Math.max(zoom, 1), 64);
    if (centre) this.centre = centre;
    if (this.zoom === 1) this.centre = null;
    this.onChange();
  }

  /** Closer or farther, around what is in the middle. */
  magnify(factor, [x, y] = [this.canvas.clientWidth / 2, this.canvas.clientHeight / 2]) {
    if (!this.placed) return;
    const { scale, left, top } = this.placed;
    const point = [(x - left) / scale, this.history.height - (y - top) / scale];
    const zoom = Math.min(Math.max(this.zoom * factor, 1), 64);
    const next = scale * (zoom / this.zoom);
    const middle = [this.canvas.clientWidth / 2, this.canvas.clientHeight / 2];
    this.turnTo(zoom, [point[0] - (x - middle[0]) / next, point[1] + (y - middle[1]) / next]);
  }

  listen() {
    const { canvas } = this;
    let dragged = null;
    const place = (event) => [event.offsetX, event.offsetY];
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.magnify(2 ** (-event.deltaY / 300), place(event));
    }, { passive: false });
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      dragged = place(event);
    });
    canvas.addEventListener("pointermove", (event) => {
      this.pointer = place(event);
      if (dragged && this.placed) {
        const { scale, left, top } = this.placed;
        const middle = [canvas.clientWidth / 2, canvas.clientHeight / 2];
        const shift = [this.pointer[0] - dragged[0], this.pointer[1] - dragged[1]];
        const x = (middle[0] - left - shift[0]) / scale;
        const y = this.history.height - (middle[1] - top - shift[1]) / scale;
        dragged = this.pointer;
        this.options.follow = this.options.follow && shift[0] === 0 && shift[1] === 0;
        this.turnTo(this.zoom, [x, y]);
      }
      this.onChange();
    });
    const end = () => { dragged = null; };
    canvas.addEventListener("pointerup", end);
    canvas.addEventListener("pointercancel", end);
    canvas.addEventListener("pointerleave", () => {
      this.pointer = null;
      this.onChange();
    });
  }
}

/** The ramp of heights, for the legend. */
export function drawRamp(canvas) {
  const context = canvas.getContext("2d");
  for (let x = 0; x < canvas.width; x += 1) {
    context.fillStyle = `rgb(${ramp(GROUND, x / (canvas.width - 1)).map(Math.round).join(" ")})`;
    context.fillRect(x, 0, 1, canvas.height);
  }
}
