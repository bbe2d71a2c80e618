// The ground as it is discovered, with route, disc, policy, goal.

import { contours } from "./contours.js";
import { UNSEEN } from "./history.js";
import { BLOCKED, COLLECTED, DARK, GOAL, GROUND, HOPPER, IMPACT, LIGHT, ROLLED, ROUTE, SAND, START, STRAY, TREASURE, VALUES, ramp, robotColour } from "./palette.js";
import { fitted, fixed } from "./scale.js";
import { colour, isStark } from "./theme.js";
import { placeOn } from "./way.js";
import { STALE_HOPS } from "./why.js";

/** About as many cells are in sight while the hopper is followed from afar. */
const FOLLOWED_CELLS = 100;

/** An arrow takes as many pixels at least. */
const ARROW_ROOM = 12;

/** Room for the ticks left of the map and below it, pixels. */
const GUTTER = { left: 44, bottom: 22, rest: 10 };

/** More cells in sight than this have no contour lines: the relief alone is read. */
const CONTOUR_CELLS = 150 * 150;

/** Height of a hop's arc on the page, as a share of the hop's length. */
const ARC = 0.45;

/** Steps of each robot that are drawn behind it; of one that announces routes, its moves. */
const TRAIL = 24;
const MOVES = 1024;

/** Side of the inset with the whole map, pixels. */
const INSET = 108;

const ARROWS = { n: -Math.PI / 2, e: 0, s: Math.PI / 2, w: Math.PI };

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
    this.options = { policy: false, values: false, follow: false, layer: "" };
    this.zoom = 1;
    this.centre = null;
    this.pointer = null;
    this.selected = null;
    this.flight = null;
    this.listen();
  }

  begin() {
    const { width, height } = this.history;
    this.layer = new OffscreenCanvas(width, height);
    this.layerContext = this.layer.getContext("2d");
    this.image = this.layerContext.createImageData(width, height);
    this.pixels = new Uint32Array(this.image.data.buffer);
    this.colours = new Uint32Array(width * height);
    this.priorLayer = null;
    this.shownAt = Infinity;
    this.range = [0, 1];
    this.isRanged = false;
    this.selected = null;
    this.flight = null;
    this.lines = null;
    this.dirty = null;
    this.small = null;
    this.centre = null;
    this.zoom = 1;
    this.valueLayer = null;
    this.forgetRoute();
  }

  forgetRoute() {
    this.route = { path: new Path2D(), stray: new Path2D(), rolled: new Path2D(), crosses: [], stuck: [], impacts: [], first: 0, from: 0, until: 0, at: -1, ways: 0 };
  }

  /** Fits the range that is shaded to the heights seen, with some room, so that it is seldom fitted again. */
  fitRange() {
    const { low, high } = this.history;
    const [rangeLow, rangeHigh] = this.range;
    if (this.isRanged && low >= rangeLow && high <= rangeHigh) return false;
    const room = Math.max(0.12 * (high - low), 0.005);
    const isLower = !this.isRanged || low < rangeLow;
    const isHigher = !this.isRanged || high > rangeHigh;
    this.range = [isLower ? low - room : rangeLow, isHigher ? high + room : rangeHigh];
    this.isRanged = true;
    return true;
  }

  /** The layers of this mission, from the monitor. */
  layers() {
    return this.history.mission?.layers ?? [];
  }

  /** The layer that is shown. */
  shown() {
    const layers = this.layers();
    return layers.find(({ name }) => name === this.options.layer) ?? layers.find(({ first }) => first);
  }

  /** Shows the layer of a name from now on. */
  choose(name) {
    if (!this.layers().some((layer) => layer.name === name)) return;
    this.options.layer = name;
    this.recolour();
  }

  /** The colour of what a layer with a scale shows of a cell at a moment, as [r, g, b]; null where it shows nothing. */
  scaleShade(layer, index, at) {
    const value = this.history.value(layer, index, at);
    return value === null ? null : ramp(layer.ramp, value / layer.most);
  }

  /** Whether shades of a scale are shown instead of the relief. */
  isOfScale() {
    return this.shown()?.look === "scale";
  }

  /** What the whole map is expected to be like under the prior, drawn beneath what was seen. */
  paintPrior() {
    this.priorLayer = null;
    const layer = this.shown();
    if (layer?.of !== "speeds" || this.history.speedsKnown === 0) return;
    const { width, height } = this.history;
    const image = new ImageData(width, height);
    const pixels = new Uint32Array(image.data.buffer);
    for (let index = 0; index < this.history.speedsKnown; index += 1) {
      const [x, y] = [index % width, Math.floor(index / width)];
      pixels[(height - 1 - y) * width + x] = pixel(this.scaleShade(layer, index, -1));
    }
    this.priorLayer = new OffscreenCanvas(width, height);
    this.priorLayer.getContext("2d").putImageData(image, 0, 0);
  }

  recolour() {
    if (!this.layer) return;
    this.paintPrior();
    this.paint({ left: 0, bottom: 0, right: this.history.width - 1, top: this.history.height - 1 });
    this.show(this.shownAt, true);
    this.valueLayer = null;
  }

  /** Takes over what is new in the history. */
  update(at) {
    if (this.history.takeFreshSpeeds()) this.recolour();
    const fresh = this.history.takeFresh();
    if (fresh) {
      this.lines = null;
      if (this.fitRange()) {
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
    const [sand, blocked] = [rgb(SAND), rgb(BLOCKED)];
    const relief = 1.6 / Math.max(this.history.mission.grid.cell_size_m, 1e-9);
    const gain = high - low < 4 ? 1.3 : 0.8;
    const [isOfScale, layer] = [this.isOfScale(), this.shown()];
    for (let y = bottom; y <= top; y += 1) {
      for (let x = left; x <= right; x += 1) {
        const index = y * width + x;
        if (seenAt[index] === UNSEEN) continue;
        if (isOfScale) {
          // No relief: a shade has to be that of the legend.
          this.colours[index] = pixel(this.scaleShade(layer, index, Infinity) ?? rgb(BLOCKED));
          continue;
        }
        const here = heights[index];
        const beside = (dx, dy) => {
          const [i, j] = [x + dx, y + dy];
          if (i < 0 || j < 0 || i >= width || j >= height) return here;
          const neighbour = j * width + i;
          return seenAt[neighbour] === UNSEEN ? here : heights[neighbour];
        };
        // Light from the north-west.
        const slope = (beside(1, 0) - beside(-1, 0) - beside(0, 1) + beside(0, -1)) * relief * gain;
        const light = 1 - 0.3 * Math.tanh(slope / 2);
        let shade = ramp(GROUND, (here - low) / (high - low)).map((band) => Math.min(band * light, 255));
        if (flags[index] & 1) shade = shade.map((band, n) => 0.6 * band + 0.4 * sand[n] * light);
        if (flags[index] & 2) shade = shade.map((band, n) => 0.35 * band + 0.65 * blocked[n]);
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
    const { bottom: low, top: high } = this.dirty ?? { bottom, top };
    this.dirty = { bottom: Math.min(low, bottom), top: Math.max(high, top) };
    this.layerContext.putImageData(this.image, 0, 0, left, height - 1 - top, right - left + 1, top - bottom + 1);
  }

  /** The rows whose pixels are new since it was asked for last. */
  takeDirty() {
    const { dirty } = this;
    this.dirty = null;
    return dirty;
  }

  show(at, anew = false) {
    if (at === this.shownAt && !anew) return;
    this.shownAt = at;
    this.reveal({ left: 0, bottom: 0, right: this.history.width - 1, top: this.history.height - 1 }, at);
  }

  /** Where the map lies on the canvas: its scale, and the corner of cell (0, 0)'s row from the top. */
  frame(width, height) {
    const { history } = this;
    const [wide, tall] = [width - GUTTER.left - GUTTER.rest, height - GUTTER.bottom - GUTTER.rest];
    const whole = Math.min(wide / history.width, tall / history.height);
    const scale = whole * this.zoom;
    let [x, y] = [history.width / 2, history.height / 2];
    if (this.zoom > 1 && this.centre) {
      const [halfX, halfY] = [Math.min(wide / scale / 2, x), Math.min(tall / scale / 2, y)];
      x = Math.min(Math.max(this.centre[0], halfX), history.width - halfX);
      y = Math.min(Math.max(this.centre[1], halfY), history.height - halfY);
    }
    const left = GUTTER.left + wide / 2 - x * scale;
    const top = GUTTER.rest + tall / 2 - (history.height - y) * scale;
    // What of the map is in sight.
    const view = {
      left: Math.max(left, GUTTER.left), right: Math.min(left + history.width * scale, width - GUTTER.rest),
      top: Math.max(top, GUTTER.rest), bottom: Math.min(top + history.height * scale, height - GUTTER.bottom),
    };
    return { scale, left, top, view };
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
    const { scale, left, top, view } = frame;
    const flight = this.flightAt(at);
    context.save();
    context.beginPath();
    context.rect(view.left, view.top, view.right - view.left, view.bottom - view.top);
    context.fillStyle = this.hatch(context);
    context.fill();
    context.clip();
    context.imageSmoothingEnabled = scale < 1.5;
    if (this.priorLayer) {
      context.drawImage(this.priorLayer, left, top, history.width * scale, history.height * scale);
      context.fillStyle = this.veil(context);
      context.fillRect(view.left, view.top, view.right - view.left, view.bottom - view.top);
    }
    context.drawImage(this.layer, left, top, history.width * scale, history.height * scale);
    if (scale >= 5 && !this.isOfScale()) this.drawSand(context, frame, at);
    const policy = this.policyAt(at);
    if (policy && this.options.values) this.drawValues(context, policy, frame, at);
    if (this.shown().look === "entries") this.drawVisits(context, frame, at);
    this.drawContours(context, frame, at);
    if (scale >= 14) this.drawGrid(context, frame, width, height);
    if (policy && this.options.policy) {
      this.drawArrows(context, policy, frame, width, height, at);
      this.drawExpected(context, policy, frame, at, pose.cell);
    }
    if (history.mission.hops) this.drawDisc(context, frame, pose);
    this.drawRoute(context, frame, flight ? at - 1 : at);
    if (this.selected) this.drawSelected(context, frame);
    this.drawMarks(context, frame, at, flight);
    context.restore();
    context.strokeStyle = colour("edge");
    context.lineWidth = 1;
    context.strokeRect(view.left - 0.5, view.top - 0.5, view.right - view.left + 1, view.bottom - view.top + 1);
    this.drawTicks(context, frame);
    this.drawFar(context, frame, at);
    if (flight) this.onChange();
  }

  drawDisc(context, frame, pose) {
    const disc = this.history.radiusCells(pose.heightM) * frame.scale;
    const [x, y] = this.spot(pose.cell, frame);
    context.beginPath();
    context.arc(x, y, disc, 0, 2 * Math.PI);
    context.lineWidth = 3;
    context.strokeStyle = "#ffffffb0";
    context.stroke();
    context.lineWidth = 1.4;
    context.setLineDash([5, 4]);
    context.strokeStyle = DARK;
    context.stroke();
    context.setLineDash([]);
  }

  /** Dots on sand: it differs from hard ground without colour too. */
  drawSand(context, { scale, left, top, view }, at) {
    const { history } = this;
    const size = Math.max(scale * 0.07, 0.9);
    context.fillStyle = "#2f3338b0";
    context.beginPath();
    const cells = this.inSight({ scale, left, top, view });
    for (let y = cells.bottom; y <= cells.top; y += 1) {
      for (let x = cells.left; x <= cells.right; x += 1) {
        const index = y * history.width + x;
        if (!(history.flags[index] & 1) || history.seenAt[index] > at) continue;
        const [cx, cy] = this.spot([x, y], { scale, left, top });
        for (const [dx, dy] of [[-0.28, -0.24], [0.24, -0.3], [-0.02, 0.04], [-0.3, 0.3], [0.3, 0.26]]) {
          context.rect(cx + dx * scale, cy + dy * scale, size, size);
        }
      }
    }
    context.fill();
  }

  /** The cells in sight. */
  inSight({ scale, left, top, view }) {
    const { width, height } = this.history;
    return {
      left: Math.max(Math.floor((view.left - left) / scale), 0), right: Math.min(Math.ceil((view.right - left) / scale), width) - 1,
      bottom: Math.max(Math.floor(height - (view.bottom - top) / scale), 0), top: Math.min(Math.ceil(height - (view.top - top) / scale), height) - 1,
    };
  }

  drawContours(context, frame, at) {
    const cells = this.inSight(frame);
    if ((cells.right - cells.left) * (cells.top - cells.bottom) > CONTOUR_CELLS || this.history.seen < 4) return;
    const until = Math.min(at, this.history.due);
    const key = `${Object.values(cells)}:${until < this.history.due ? until : "now"}:${this.range}`;
    if (this.lines?.key !== key) this.lines = { key, ...contours(this.history, cells, this.range, until) };
    context.save();
    context.translate(frame.left, frame.top);
    context.scale(frame.scale, frame.scale);
    context.strokeStyle = isStark() ? "#000" : "#4a352680";
    context.lineWidth = 1 / frame.scale;
    context.stroke(this.lines.path);
    context.restore();
  }

  /** Ticks in metres along the left and the lower edge. */
  drawTicks(context, { scale, left, top, view }) {
    const { cell_size_m: cellM } = this.history.mission.grid;
    const perMetre = scale / cellM;
    const stepM = [0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000].find((m) => m * perMetre >= 56) ?? 10000;
    // As in the pictures, metres count from the middle of cell (0, 0).
    const [west, south] = [left + scale / 2, top + (this.history.height - 0.5) * scale];
    context.font = "10px system-ui, sans-serif";
    context.fillStyle = colour("dim");
    context.textBaseline = "alphabetic";
    context.textAlign = "center";
    const name = (m) => `${Number(m.toPrecision(6)) || 0}`;
    for (let n = Math.ceil((view.left - west) / perMetre / stepM); west + n * stepM * perMetre <= view.right + 0.5; n += 1) {
      const x = west + n * stepM * perMetre;
      context.fillRect(Math.round(x), view.bottom + 1, 1, 4);
      context.fillText(name(n * stepM), x, view.bottom + 16);
    }
    context.textAlign = "right";
    context.textBaseline = "middle";
    for (let n = Math.ceil((south - view.bottom) / perMetre / stepM); south - n * stepM * perMetre >= view.top - 0.5; n += 1) {
      const y = south - n * stepM * perMetre;
      context.fillRect(view.left - 5, Math.round(y), 4, 1);
      context.fillText(name(n * stepM), view.left - 8, y);
    }
    context.textBaseline = "alphabetic";
    context.fillText("m", view.left - 8, view.bottom + 16);
    context.textAlign = "left";
  }

  /** The whole map in a corner while only part of it is in sight, and an arrow to the goal beyond the edge. */
  drawFar(context, frame, at) {
    const { history } = this;
    const { view, left, top, scale } = frame;
    const whole = history.width * scale <= view.right - view.left + 1 && history.height * scale <= view.bottom - view.top + 1;
    if (whole) return;
    const side = INSET / Math.max(history.width, history.height);
    const [wide, tall] = [history.width * side, history.height * side];
    const goalCell = history.robots === 1 ? history.goal(at) : null;
    // In the corner that is farthest from the goal, so that it covers neither the goal nor what points to it.
    const isGoalRight = goalCell && this.spot(goalCell, frame)[0] > (view.left + view.right) / 2;
    const [x, y] = [isGoalRight ? view.left + 8 : view.right - wide - 8, view.top + 8];
    const goal = goalCell ? this.spot(goalCell, frame) : [view.left + 1, view.top + 1];
    const margin = 16;
    const place = [Math.min(Math.max(goal[0], view.left + margin), view.right - margin), Math.min(Math.max(goal[1], view.top + margin), view.bottom - margin)];
    if (place[0] !== goal[0] && goal[0] < view.left || place[0] !== goal[0] && goal[0] > view.right || goal[1] < view.top || goal[1] > view.bottom) {
      const turn = Math.atan2(goal[1] - place[1], goal[0] - place[0]);
      context.save();
      context.translate(...place);
      context.rotate(turn);
      context.beginPath();
      context.moveTo(12, 0); context.lineTo(-7, -8); context.lineTo(-3, 0); context.lineTo(-7, 8); context.closePath();
      context.lineJoin = "round";
      context.lineWidth = 4; context.strokeStyle = LIGHT; context.stroke();
      context.fillStyle = GOAL; context.fill();
      context.restore();
      const text = `goal ${this.distanceM(goalCell, history.pose(at).cell).toFixed(0)} m`;
      context.font = "600 11px system-ui, sans-serif";
      context.textBaseline = "middle";
      const room = context.measureText(text).width;
      const textX = Math.min(Math.max(place[0] - room / 2, view.left + 6), view.right - room - 6);
      const textY = place[1] + (place[1] > (view.top + view.bottom) / 2 ? -22 : 22);
      context.fillStyle = "#ffffffd8"; context.fillRect(textX - 4, textY - 8, room + 8, 16);
      context.fillStyle = DARK; context.fillText(text, textX, textY);
      context.textBaseline = "alphabetic";
    }
    context.save();
    context.globalAlpha = 0.94;
    context.fillStyle = colour("unseen"); context.fillRect(x, y, wide, tall);
    context.drawImage(this.thumbnail(wide, tall), x, y, wide, tall);
    context.globalAlpha = 1;
    context.strokeStyle = colour("dim"); context.lineWidth = 1; context.strokeRect(x - 0.5, y - 0.5, wide + 1, tall + 1);
    const corner = (px, py) => [x + ((px - left) / scale) * side, y + ((py - top) / scale) * side];
    const [[x0, y0], [x1, y1]] = [corner(view.left, view.top), corner(view.right, view.bottom)];
    context.strokeStyle = LIGHT; context.lineWidth = 3; context.strokeRect(x0, y0, x1 - x0, y1 - y0);
    context.strokeStyle = DARK; context.lineWidth = 1.2; context.strokeRect(x0, y0, x1 - x0, y1 - y0);
    const dot = ([cx, cy], fill, radius) => {
      context.beginPath();
      context.arc(x + (cx + 0.5) * side, y + (history.height - 0.5 - cy) * side, radius, 0, 2 * Math.PI);
      context.fillStyle = fill; context.fill(); context.strokeStyle = DARK; context.lineWidth = 1; context.stroke();
    };
    if (goalCell) dot(goalCell, GOAL, 3.5);
    if (history.robots === 1) dot(history.pose(at).cell, HOPPER, 3.5);
    else history.poses(at).forEach(({ cell }, robot) => cell && dot(cell, robotColour(robot), 3.5));
    context.restore();
  }

  /** The whole map in small, made anew once a second at most: of a large map it would cost more than all else. */
  thumbnail(wide, tall) {
    const now = performance.now();
    const ratio = window.devicePixelRatio || 1;
    const size = [Math.max(Math.round(wide * ratio), 1), Math.max(Math.round(tall * ratio), 1)];
    if (!this.small || this.small.width !== size[0] || this.small.height !== size[1]) {
      this.small = new OffscreenCanvas(...size);
      this.smallAt = -Infinity;
    }
    if (now - this.smallAt > 1000) {
      const pen = this.small.getContext("2d");
      pen.clearRect(0, 0, ...size);
      pen.drawImage(this.layer, 0, 0, ...size);
      this.smallAt = now;
    }
    return this.small;
  }

  distanceM(a, b) {
    return Math.hypot(a[0] - b[0], a[1] - b[1]) * this.history.mission.grid.cell_size_m;
  }

  /** Starts to show the hop that led to `at` in flight; `lastsMs` says for how long, of its way or of none. */
  launch(at, lastsMs) {
    const hop = this.history.hopBefore(at);
    if (!hop || hop.branch === "held") return;
    const way = this.history.wayOf(hop);
    this.flight = { at, began: performance.now(), way, lastsMs, ms: lastsMs(way) };
  }

  /** The flight that is under way at a moment, with its share, 0 to 1. */
  flightAt(at) {
    if (!this.flight || this.flight.at !== at) return null;
    const { flight, history } = this;
    const hop = history.hopBefore(at);
    // Its way may become known a moment later than the hop: then it begins again, as it was.
    const way = history.wayOf(hop);
    if (way !== flight.way) Object.assign(flight, { way, began: performance.now(), ms: flight.lastsMs(way) });
    const share = (performance.now() - flight.began) / flight.ms;
    if (!(share < 1)) {
      this.flight = null;
      return null;
    }
    return { hop, way, share, ms: flight.ms };
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

  /** Lines over ground that is only expected: it differs from what was seen without colour too. */
  veil(context) {
    if (!this.veiled) {
      this.veiled = new OffscreenCanvas(8, 8);
      const pen = this.veiled.getContext("2d");
      for (const [ink, shift] of [["#ffffff70", 0], ["#00000060", 1]]) {
        pen.strokeStyle = ink;
        pen.lineWidth = 0.8;
        for (const from of [-8, 0, 8]) {
          pen.beginPath();
          pen.moveTo(from + shift, 8);
          pen.lineTo(from + shift + 8, 0);
          pen.stroke();
        }
      }
    }
    return context.createPattern(this.veiled, "repeat");
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

  drawValues(context, policy, { scale, left, top }, at) {
    const goal = this.history.goal(at);
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
        // The goal absorbs: its value is 0, and nothing is worth more than being there.
        const isGoal = x + policy.x === goal[0] && y + policy.y === goal[1];
        pixels[(policy.height - 1 - y) * policy.width + x] = pixel(ramp(VALUES, isGoal ? 1 : rank(policy.values[n])));
      }
      pen.putImageData(image, 0, 0);
      this.valueLayer = { policy, layer };
    }
    context.globalAlpha = this.age(policy, at) > STALE_HOPS ? 0.4 : 0.8;
    const y = top + (this.history.height - policy.y - policy.height) * scale;
    context.drawImage(this.valueLayer.layer, left + policy.x * scale, y, policy.width * scale, policy.height * scale);
    context.globalAlpha = 1;
  }

  drawArrows(context, policy, frame, width, height, at) {
    const { scale } = frame;
    // From afar every other cell has an arrow, or every third: they shall be read.
    const stride = Math.ceil(ARROW_ROOM / scale);
    if (stride > 8) return;
    // Faint, and fainter on what was not seen: the expected route shall stand out.
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
    context.strokeStyle = isStark() ? "#000000" : this.options.values ? "#ffffffb0" : "#1b130c60";
    context.stroke(arms);
    context.strokeStyle = this.options.values ? "#ffffff70" : colour("arrow");
    context.stroke(faint);
  }

  /** How many hops lie between a policy and a moment. */
  age(policy, at) {
    return Math.abs(Math.min(at, this.history.due) - policy.decision);
  }

  /** The route that the policy expects from a cell, every hop landing as aimed. */
  expected(policy, cell, at) {
    const { width, height, history } = { ...policy, history: this.history };
    const goal = history.goal(at);
    const hop = history.mission.grid.hop_cells;
    const cells = [cell];
    let [x, y] = cell;
    const been = new Set();
    while (cells.length < 4 * (width + height) && !(x === goal[0] && y === goal[1])) {
      const [column, row] = [x - policy.x, y - policy.y];
      if (column < 0 || row < 0 || column >= width || row >= height || been.has(row * width + column)) break;
      been.add(row * width + column);
      const turn = ARROWS[policy.actions[row * width + column]];
      if (turn === undefined) break;
      [x, y] = [x + hop * Math.round(Math.cos(turn)), y - hop * Math.round(Math.sin(turn))];
      cells.push([x, y]);
    }
    return cells;
  }

  drawExpected(context, policy, frame, at, from) {
    const cells = this.expected(policy, from, at);
    if (cells.length < 2) return;
    context.beginPath();
    cells.forEach((cell, n) => context[n ? "lineTo" : "moveTo"](...this.spot(cell, frame)));
    context.lineJoin = "round";
    context.lineCap = "round";
    const thick = frame.scale > 10 ? 2.6 : 1.8;
    context.globalAlpha = this.age(policy, at) > STALE_HOPS ? 0.4 : 1;
    context.lineWidth = thick + 2.6;
    context.strokeStyle = "#ffffffc0";
    context.stroke();
    context.setLineDash([0.1, 2.2 * thick]);
    context.lineWidth = thick + 0.6;
    context.strokeStyle = DARK;
    context.stroke();
    context.setLineDash([]);
    context.globalAlpha = 1;
  }

  drawSelected(context, frame) {
    const [x, y] = this.spot(this.selected, frame);
    const half = Math.max(frame.scale / 2, 5);
    for (const [width, ink] of [[4, LIGHT], [2, DARK]]) {
      context.lineWidth = width;
      context.strokeStyle = ink;
      context.strokeRect(x - half, y - half, 2 * half, 2 * half);
    }
  }

  /** The route grows with the mission; it is made anew only when time goes back or, of visits in turn, with a visit. */
  routeUntil(at) {
    const { history } = this;
    const from = history.routeFrom(at);
    if (at < this.route.at || this.route.first !== history.first || this.route.from !== from || this.route.ways !== history.waysKnown) {
      this.forgetRoute();
      Object.assign(this.route, { first: history.first, from, until: from, ways: history.waysKnown });
    }
    const { route } = this;
    const y = (cell) => history.height - 0.5 - cell[1];
    for (; route.until < history.hops.length && history.first + route.until < at; route.until += 1) {
      const hop = history.hops[route.until];
      if (hop.robot > 0) continue;
      const way = history.wayOf(hop);
      if (way) {
        this.addWay(route, hop, way);
        continue;
      }
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

  /** The way of a hop on the ground: below its flights, and where it hit and rolled. */
  addWay(route, hop, way) {
    const { height } = this.history;
    const middle = ([x, y]) => [x - 0.5, y - 0.5];
    if (hop.branch === "stayed") route.stuck.push(middle(way.rest));
    else if (hop.stray) route.crosses.push(middle(way.rest));
    for (const { from, to, climbMps } of way.stretches) {
      const path = climbMps === null ? route.rolled : hop.stray ? route.stray : route.path;
      path.moveTo(from[0], height - from[1]);
      path.lineTo(to[0], height - to[1]);
    }
    route.impacts.push(...way.impacts.map(({ at }) => middle(at)));
  }

  /** Where bodies hit the ground: diamonds. */
  drawImpacts(context, frame, impacts) {
    const size = Math.min(Math.max(frame.scale * 0.09, 2.6), 5);
    context.beginPath();
    for (const place of impacts) {
      const [x, y] = this.spot(place, frame);
      context.moveTo(x, y - size); context.lineTo(x + size, y); context.lineTo(x, y + size); context.lineTo(x - size, y); context.closePath();
    }
    context.lineJoin = "miter";
    context.lineWidth = 2;
    context.strokeStyle = DARK;
    context.stroke();
    context.fillStyle = IMPACT;
    context.fill();
  }

  /** A place of the map in cells from its south-western corner, on the canvas. */
  corner([x, y], { scale, left, top }) {
    return [left + x * scale, top + (this.history.height - y) * scale];
  }

  /** A path through places of the map. */
  trace(context, points, frame) {
    context.beginPath();
    points.forEach((point, n) => context[n ? "lineTo" : "moveTo"](...this.corner(point, frame)));
  }

  /** What cameras see along the routes that robots announced, and around where they are. */
  drawSights(context, frame, at) {
    const { history } = this;
    history.poses(at).forEach(({ cell }, robot) => {
      const reach = history.viewCells(robot);
      if (reach === null) return;
      const route = history.routeOf(robot, at);
      if (route) this.drawBand(context, route.points, frame, reach, robotColour(robot));
      if (!cell) return;
      const [x, y] = this.spot(cell, frame);
      for (const [width, ink] of [[4, "#111111a0"], [1.8, robotColour(robot)]]) {
        context.beginPath();
        context.arc(x, y, reach * frame.scale, 0, 2 * Math.PI);
        context.lineWidth = width;
        context.strokeStyle = ink;
        context.stroke();
      }
    });
  }

  /** The border of what is at most `reach` cells from a route: no tint, which would change the shades beneath. */
  drawBand(context, points, frame, reach, ink) {
    const { width, height } = this.canvas;
    if (this.band?.width !== width || this.band?.height !== height) this.band = new OffscreenCanvas(width, height);
    const pen = this.band.getContext("2d");
    pen.setTransform(1, 0, 0, 1, 0, 0);
    pen.clearRect(0, 0, width, height);
    pen.setTransform(context.getTransform());
    pen.lineCap = "round";
    pen.lineJoin = "round";
    this.trace(pen, points, frame);
    for (const [operation, border, colour] of [["source-over", 1.6, "#111111"], ["source-over", 0.8, ink], ["destination-out", -0.8, ink]]) {
      pen.globalCompositeOperation = operation;
      pen.lineWidth = Math.max(2 * (reach * frame.scale + border), 0.1);
      pen.strokeStyle = colour;
      pen.stroke();
    }
    pen.globalCompositeOperation = "source-over";
    context.drawImage(this.band, 0, 0, this.canvas.clientWidth, this.canvas.clientHeight);
  }

  /** The routes that robots follow at a moment, dashed. */
  drawAnnounced(context, frame, at) {
    const { history } = this;
    for (let robot = 0; robot < history.robots; robot += 1) {
      const route = history.routeOf(robot, at);
      if (!route) continue;
      context.lineCap = "butt";
      context.lineJoin = "round";
      for (const [width, ink] of [[5.6, "#ffffffc0"], [4.2, "#111111d0"], [2.2, robotColour(robot)]]) {
        context.setLineDash(width > 3 ? [10, 6] : [8, 8]);
        context.lineDashOffset = width > 3 ? 1 : 0;
        this.trace(context, route.points, frame);
        context.lineWidth = width;
        context.strokeStyle = ink;
        context.stroke();
      }
      context.setLineDash([]);
      context.lineDashOffset = 0;
    }
  }

  /** The last steps of each robot before a moment. */
  trailOf(at) {
    const { history } = this;
    const most = history.mission.hops || history.routes.length > 0 ? MOVES : TRAIL;
    return history.hopsUntil(at, most * history.robots).filter(({ from, to }) => from[0] !== to[0] || from[1] !== to[1]);
  }

  /** The last steps of each robot in its colour; a hopper's route is drawn otherwise. */
  drawTrails(context, frame, at) {
    const { history } = this;
    const ends = new Map();
    context.lineCap = "round";
    for (const hop of this.trailOf(at)) {
      if (history.mission.hops && hop.robot === 0) continue;
      if (!ends.has(hop.robot)) ends.set(hop.robot, []);
      ends.get(hop.robot).push(hop);
    }
    for (const [robot, hops] of ends) {
      context.beginPath();
      let before = null;
      for (const hop of hops) {
        // A helicopter that is with its rover again has not flown there.
        const way = history.wayOf(hop);
        if (!before || before[0] !== hop.from[0] || before[1] !== hop.from[1]) context.moveTo(...(way?.launch ? this.corner(way.launch.at, frame) : this.spot(hop.from, frame)));
        for (const { at: impact } of way?.impacts ?? []) context.lineTo(...this.corner(impact, frame));
        context.lineTo(...(way ? this.corner(way.rest, frame) : this.spot(hop.to, frame)));
        before = hop.to;
      }
      context.lineJoin = "round";
      for (const [width, ink] of [[6.4, "#ffffffb0"], [4.6, "#111111d0"], [2.6, robotColour(robot)]]) {
        context.lineWidth = width;
        context.strokeStyle = ink;
        context.stroke();
      }
    }
  }

  drawRoute(context, frame, at) {
    if (this.history.robots > 1) {
      this.drawSights(context, frame, at);
      this.drawAnnounced(context, frame, at);
      this.drawTrails(context, frame, at);
      if (!this.history.mission.hops) return;
    }
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
    const casing = isStark() ? LIGHT : "#ffffffd8";
    const thick = scale > 10 ? 3 : 1.8;
    trace(route.path, casing, thick + 3, []);
    trace(route.stray, casing, thick + 3, []);
    trace(route.rolled, casing, thick + 3, []);
    // Of several robots each has the colour of its marker.
    if (this.history.robots > 1) trace(route.path, DARK, thick + 1.6, []);
    trace(route.path, this.history.robots > 1 ? robotColour(0) : ROUTE, thick, []);
    trace(route.stray, STRAY, thick, [1.4 * thick, 2 * thick]);
    trace(route.rolled, ROLLED, thick, []);
    const size = Math.min(Math.max(scale * 0.16, 2.5), 5);
    context.strokeStyle = STRAY;
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
    if (scale >= 4) this.drawImpacts(context, frame, route.impacts);
  }

  drawMarks(context, frame, at, flight) {
    const { history } = this;
    const isTeam = history.robots > 1;
    const size = Math.min(Math.max(frame.scale * 0.3, 6), 10);
    const symbol = (trace, fill, rim, width = 1.8) => {
      context.beginPath();
      trace();
      context.lineJoin = "round";
      context.lineWidth = width + 2.4;
      context.strokeStyle = rim === DARK ? LIGHT : DARK;
      context.stroke();
      context.lineWidth = width;
      context.strokeStyle = rim;
      context.stroke();
      context.fillStyle = fill;
      context.fill();
    };
    const star = (cx, cy, reach) => () => {
      for (let n = 0; n < 10; n += 1) {
        const [turn, length] = [(n * Math.PI) / 5 - Math.PI / 2, reach * (n % 2 ? 0.62 : 1.45)];
        context.lineTo(cx + Math.cos(turn) * length, cy + Math.sin(turn) * length);
      }
      context.closePath();
    };
    if (!history.mission.hops) {
      history.mission.robots.forEach(({ body, start, goals }, robot) => {
        if (body !== "rover") {
          const [startX, startY] = this.corner(start, frame);
          symbol(() => context.arc(startX, startY, size * 0.6, 0, 2 * Math.PI), robotColour(robot), DARK);
        }
        for (const goal of goals) symbol(star(...this.corner(goal, frame), size * 1.25), robotColour(robot), DARK);
      });
      this.drawRobots(context, frame, at, symbol);
      return;
    }
    for (const treasure of history.treasures(at)) symbol(star(...this.spot(treasure, frame), size * 0.72), TREASURE, LIGHT);
    for (const { cell, decision } of history.collections) if (decision < at) symbol(star(...this.spot(cell, frame), size * 0.72), COLLECTED, DARK);
    const [startX, startY] = this.spot(history.mission.start, frame);
    symbol(() => context.arc(startX, startY, size * 0.8, 0, 2 * Math.PI), isTeam ? robotColour(0) : START, isTeam ? DARK : LIGHT);
    const goal = history.goal(at);
    for (const other of history.mission.goals) {
      if (other !== goal) context.globalAlpha = 0.55;
      if (isTeam) symbol(star(...this.spot(other, frame), size * 1.25), robotColour(0), DARK);
      else symbol(star(...this.spot(other, frame), size), GOAL, LIGHT);
      context.globalAlpha = 1;
    }
    if (history.robots > 1) {
      this.drawRobots(context, frame, at, symbol);
      return;
    }
    const hop = flight?.hop ?? history.hopBefore(at);
    if (hop?.stray && history.aimOf(hop) && !history.isOver(at)) this.drawAim(context, frame, hop);
    const pose = history.pose(at);
    let [x, y] = this.corner(history.place(at), frame);
    if (flight) [x, y] = this.drawFlight(context, frame, flight);
    if (history.inside(pose.cell) || flight) symbol(() => context.arc(x, y, size * 0.68, 0, 2 * Math.PI), HOPPER, DARK);
    else {
      context.font = "600 11px system-ui, sans-serif";
      context.fillStyle = colour("bad");
      context.fillText("off the map", Math.min(Math.max(x, frame.view.left + 4), frame.view.right - 70), Math.min(Math.max(y, frame.view.top + 14), frame.view.bottom - 6));
    }
  }

  /** Where a stray hop had been aimed. */
  drawAim(context, frame, hop) {
    const aim = this.history.aimOf(hop);
    const launch = this.history.wayOf(hop)?.launch;
    const [x, y] = this.spot([hop.from[0] + aim[0], hop.from[1] + aim[1]], frame);
    const [fromX, fromY] = launch ? this.corner(launch.at, frame) : this.spot(hop.from, frame);
    const radius = Math.min(Math.max(frame.scale * 0.28, 4), 9);
    context.lineCap = "round";
    for (const [width, ink] of [[3.4, "#ffffffc0"], [1.6, STRAY]]) {
      context.lineWidth = width;
      context.strokeStyle = ink;
      context.setLineDash([2, 4]);
      context.beginPath();
      context.moveTo(fromX, fromY);
      context.lineTo(x, y);
      context.stroke();
      context.setLineDash([]);
      context.beginPath();
      context.arc(x, y, radius, 0, 2 * Math.PI);
      context.stroke();
    }
  }

  /** The arc of a hop, as far as it is flown; returns where the hopper is on it. */
  drawFlight(context, frame, { hop, way, share }) {
    if (way) return this.drawWay(context, frame, hop, way, share * way.seconds);
    const [[fromX, fromY], [toX, toY]] = [this.spot(hop.from, frame), this.spot(hop.to, frame)];
    const reach = Math.max(Math.hypot(toX - fromX, toY - fromY), hop.branch === "stayed" ? frame.scale * 0.6 : 0);
    const along = (part) => [fromX + (toX - fromX) * part, fromY + (toY - fromY) * part - ARC * reach * 4 * part * (1 - part)];
    const at = along(share);
    const [shadowX, shadowY] = [fromX + (toX - fromX) * share, fromY + (toY - fromY) * share];
    context.beginPath();
    context.ellipse(shadowX, shadowY, Math.max(frame.scale * 0.2, 4), Math.max(frame.scale * 0.1, 2), 0, 0, 2 * Math.PI);
    context.fillStyle = "#00000070";
    context.fill();
    context.beginPath();
    for (let n = 0; n <= 16; n += 1) context[n ? "lineTo" : "moveTo"](...along((share * n) / 16));
    context.lineCap = "round";
    for (const [width, ink] of [[4.5, "#ffffffd0"], [2.4, hop.stray ? STRAY : ROUTE]]) {
      context.lineWidth = width;
      context.strokeStyle = ink;
      context.stroke();
    }
    return at;
  }

  /** The way of a hop until so many seconds after its launch; returns where the hopper is on it. */
  drawWay(context, frame, hop, way, seconds) {
    const { cell_size_m: cellM } = this.history.mission.grid;
    const over = ({ place, liftM }) => {
      const [x, y] = this.corner(place, frame);
      return [x, y - (liftM / cellM) * frame.scale];
    };
    const trace = (stretches, ink) => {
      context.beginPath();
      for (const stretch of stretches) {
        const share = stretch.ends > stretch.begins ? Math.min((seconds - stretch.begins) / (stretch.ends - stretch.begins), 1) : 1;
        for (let n = 0; n <= 16; n += 1) context[n ? "lineTo" : "moveTo"](...over(placeOn(stretch, (share * n) / 16)));
      }
      context.lineCap = "round";
      for (const [width, stroke] of [[4.5, "#ffffffd0"], [2.4, ink]]) {
        context.lineWidth = width;
        context.strokeStyle = stroke;
        context.stroke();
      }
    };
    const begun = way.stretches.filter(({ begins }) => begins <= seconds);
    trace(begun.filter(({ climbMps }) => climbMps !== null), hop.stray ? STRAY : ROUTE);
    trace(begun.filter(({ climbMps }) => climbMps === null), ROLLED);
    this.drawImpacts(context, frame, way.impacts.filter((impact) => impact.seconds <= seconds).map(({ at: [x, y] }) => [x - 0.5, y - 0.5]));
    const now = way.at(seconds);
    const [shadowX, shadowY] = this.corner(now.place, frame);
    context.beginPath();
    context.ellipse(shadowX, shadowY, Math.max(frame.scale * 0.2, 4), Math.max(frame.scale * 0.1, 2), 0, 0, 2 * Math.PI);
    context.fillStyle = "#00000070";
    context.fill();
    return over(now);
  }

  /** The robots, each with its colour and number, a hopper round, a rover square, a helicopter with a corner up; the one whose turn it is has a
   * ring. Those on one cell stand side by side. */
  drawRobots(context, frame, at, symbol) {
    const { history } = this;
    const size = Math.min(Math.max(frame.scale * 0.42, 8), 14);
    const due = history.turn(at);
    const beside = new Map();
    history.poses(at).forEach(({ cell, rest, standing }, robot) => {
      if (!cell) return;
      const { body } = history.mission.robots[robot];
      const others = beside.get(`${cell}`) ?? 0;
      beside.set(`${cell}`, others + 1);
      const [placeX, y] = rest ? this.corner(rest, frame) : this.spot(cell, frame);
      const x = placeX + others * 2 * size;
      const shapes = {
        hopper: () => context.arc(x, y, size, 0, 2 * Math.PI),
        helicopter: () => {
          const reach = 1.35 * size;
          context.moveTo(x, y - reach); context.lineTo(x + reach, y); context.lineTo(x, y + reach); context.lineTo(x - reach, y); context.closePath();
        },
      };
      const fill = robotColour(robot);
      if (robot === due) {
        for (const [width, ink] of [[5, LIGHT], [2.4, DARK]]) {
          context.beginPath();
          context.arc(x, y, size * 1.45, 0, 2 * Math.PI);
          context.lineWidth = width;
          context.strokeStyle = ink;
          context.stroke();
        }
      }
      symbol(shapes[body] ?? (() => context.rect(x - 0.9 * size, y - 0.9 * size, 1.8 * size, 1.8 * size)), fill, DARK);
      context.fillStyle = DARK;
      context.font = `700 ${Math.round(size * 1.15)}px system-ui, sans-serif`;
      context.textAlign = "center";
      context.textBaseline = "middle";
      context.fillText(standing === "stranded" ? "×" : `${robot}`, x, y + 0.5);
      context.textAlign = "left";
      context.textBaseline = "alphabetic";
    });
  }

  /** How often each cell was entered, by the shade of a square on it. */
  drawVisits(context, frame, at) {
    const { history } = this;
    const cells = this.inSight(frame);
    const visits = history.visitsUntil(at);
    const inset = frame.scale > 8 ? 0.16 : 0;
    for (let y = cells.bottom; y <= cells.top; y += 1) {
      for (let x = cells.left; x <= cells.right; x += 1) {
        const count = visits[y * history.width + x];
        if (!count) continue;
        const left = frame.left + (x + inset) * frame.scale;
        const top = frame.top + (history.height - 1 - y + inset) * frame.scale;
        context.fillStyle = `rgb(0 95 143 / ${Math.min(0.28 + 0.17 * (count - 1), 0.9)})`;
        context.fillRect(left, top, frame.scale * (1 - 2 * inset), frame.scale * (1 - 2 * inset));
      }
    }
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
    const size = history.mission.grid.cell_size_m;
    const words = [`cell (${cell[0]}, ${cell[1]})`, `${Number((cell[0] * size).toFixed(2))}, ${Number((cell[1] * size).toFixed(2))} m`];
    if (history.seenAt[index] > at) words.push("unseen");
    else {
      words.push(`${fixed(history.heights[index], 2)} m`, history.flags[index] & 1 ? "sand" : "hard");
      if (history.flags[index] & 2) words.push("impassable");
      words.push(`seen at ${history.decisionWord} ${history.seenAt[index]}`);
    }
    words.push(...this.values(index, at));
    const policy = this.policyAt(at);
    const [x, y] = policy ? [cell[0] - policy.x, cell[1] - policy.y] : [-1, -1];
    if (policy && x >= 0 && y >= 0 && x < policy.width && y < policy.height) {
      const goal = history.goal(at);
      words.push(cell[0] === goal[0] && cell[1] === goal[1] ? "the goal" : `value ${fixed(policy.values[y * policy.width + x], 2)}`);
    }
    return words.join(" · ");
  }

  /** What the layers with a scale show of a cell at a moment, in words: those of speeds together. */
  values(index, at) {
    const words = (layer) => {
      const value = this.history.value(layer, index, at);
      return value === null ? [] : [layer.words.replace("{}", value.toFixed(layer.most < 2 ? 2 : layer.most < 20 ? 1 : 0))];
    };
    const scales = this.layers().filter(({ look }) => look === "scale");
    const speeds = scales.filter(({ of }) => of === "speeds").flatMap(words).join(" ");
    return [...(speeds ? [speeds] : []), ...scales.filter(({ of }) => of === "cells").flatMap(words)];
  }

  turnTo(zoom, centre) {
    this.zoom = Math.min(Math.max(zoom, 1), 64);
    if (centre) this.centre = centre;
    if (this.zoom === 1) this.centre = null;
    this.onChange();
  }

  /** The middle of the map's place on the canvas. */
  middle() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    return [(GUTTER.left + width - GUTTER.rest) / 2, (GUTTER.rest + height - GUTTER.bottom) / 2];
  }

  /** Closer or farther, around what is in the middle. */
  magnify(factor, [x, y] = this.middle()) {
    if (!this.placed) return;
    const { scale, left, top } = this.placed;
    const point = [(x - left) / scale, this.history.height - (y - top) / scale];
    const zoom = Math.min(Math.max(this.zoom * factor, 1), 64);
    const next = scale * (zoom / this.zoom);
    const middle = this.middle();
    this.turnTo(zoom, [point[0] - (x - middle[0]) / next, point[1] + (y - middle[1]) / next]);
  }

  /** Chooses a cell to be explained, or none. */
  select(cell) {
    const isSame = cell && this.selected && cell[0] === this.selected[0] && cell[1] === this.selected[1];
    this.selected = isSame ? null : cell;
    this.onChange();
  }

  listen() {
    const { canvas } = this;
    let dragged = null;
    let pressed = null;
    const place = (event) => [event.offsetX, event.offsetY];
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.magnify(2 ** (-event.deltaY / 300), place(event));
    }, { passive: false });
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      dragged = place(event);
      pressed = dragged;
    });
    canvas.addEventListener("pointermove", (event) => {
      this.pointer = place(event);
      if (dragged && this.placed) {
        const { scale, left, top } = this.placed;
        const middle = this.middle();
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
    canvas.addEventListener("pointerup", (event) => {
      const [x, y] = place(event);
      // A press that did not move is a choice of a cell; the same again takes it back.
      if (pressed && Math.hypot(x - pressed[0], y - pressed[1]) < 5) this.select(this.cellAt(x, y));
      end();
    });
    canvas.addEventListener("pointercancel", end);
    canvas.addEventListener("pointerleave", () => {
      this.pointer = null;
      this.onChange();
    });
  }
}

/** A ramp for the legend. */
export function drawRamp(canvas, colours = VALUES) {
  const context = canvas.getContext("2d");
  for (let x = 0; x < canvas.width; x += 1) {
    context.fillStyle = `rgb(${ramp(colours, x / (canvas.width - 1)).map(Math.round).join(" ")})`;
    context.fillRect(x, 0, 1, canvas.height);
  }
}
