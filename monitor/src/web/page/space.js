// The same ground in space: a surface by WebGL 2. Hoppers hop in arcs, rovers drive on the ground, helicopters fly above it; unseen
// ground is flat fog.
//
// Heights and colours are textures that only change where something was seen; the mesh is made once. A frame is three
// draw calls whatever the size of the map: the ground, the lines, the symbols.

import { GOAL, HOPPER, IMPACT, ROLLED, ROUTE, START, STRAY, robotColour } from "./palette.js";
import { colour } from "./theme.js";
import { placeOn } from "./way.js";

/** Hops whose arcs are in the air: the last ones. */
const ARCS = 600;

/** Impacts that are marked: the last ones. */
const IMPACTS = 1500;

/** Segments of an arc. */
const SEGMENTS = 10;

/** Helicopters fly at this share of the map's width above the highest ground. */
const CRUISE = 0.03;

/** Angle of view from top to bottom, radians. */
const VIEW_ANGLE = 0.8;

/** Number of the mark that has a robot's number in it; the marks of further numbers follow. */
const NUMBERED = 10;
/** What the marks with a number can have in them: the numbers of robots, and what a stranded one has. */
const LABELS = [...Array(16).keys(), "×"];
/** The marks of bodies follow each other: round, square, with a corner up. */
const SHAPES = { hopper: 0, rover: 1, driver: 1, helicopter: 2 };

/** The relief is raised to this share of the map's width, by eight times at most. */
const RELIEF = 0.14;
const RAISED_MAX = 8;

const GROUND_VERTEX = `#version 300 es
uniform mat4 view; uniform sampler2D heights; uniform sampler2D colours; uniform ivec2 size; uniform float raise; uniform float floorHeight;
out vec3 shade; out float seen; out vec3 spot;
void main() {
  ivec2 cell = ivec2(gl_VertexID % size.x, gl_VertexID / size.x);
  vec4 known = texelFetch(colours, cell, 0);
  seen = known.a;
  float height = texelFetch(heights, cell, 0).r;
  if (seen < 0.5) {
    // Beside what was seen the fog is as high as that, so that it has no slope of its own.
    height = floorHeight;
    for (int n = 0; n < 9; n += 1) {
      ivec2 beside = clamp(cell + ivec2(n % 3 - 1, n / 3 - 1), ivec2(0), size - 1);
      if (texelFetch(colours, beside, 0).a > 0.5) height = max(height, texelFetch(heights, beside, 0).r);
    }
  }
  spot = vec3(vec2(cell), height * raise);
  shade = known.rgb;
  gl_Position = view * vec4(spot, 1.0);
}`;

const GROUND_FRAGMENT = `#version 300 es
precision highp float;
uniform vec3 fog;
in vec3 shade; in float seen; in vec3 spot;
out vec4 ink;
void main() {
  vec3 normal = normalize(cross(dFdx(spot), dFdy(spot)));
  if (normal.z < 0.0) normal = -normal;
  float light = seen > 0.999 ? 0.72 + 0.36 * dot(normal, normalize(vec3(-0.5, 0.6, 0.75))) : 1.0;
  // The edge of what was seen is no slope, so that it has no light.
  ink = vec4(seen > 0.5 ? shade / seen * light : fog, 1.0);
}`;

const LINE_VERTEX = `#version 300 es
uniform mat4 view; uniform vec2 screen;
in vec3 from; in vec3 to; in vec4 paint; in float width;
out vec4 ink;
void main() {
  vec4 a = view * vec4(from, 1.0), b = view * vec4(to, 1.0);
  vec2 along = normalize(b.xy / b.w * screen - a.xy / a.w * screen + vec2(1e-6, 0.0));
  vec2 across = vec2(-along.y, along.x);
  int corner = gl_VertexID;
  vec4 end = corner < 2 ? a : b;
  float side = (corner & 1) == 0 ? -1.0 : 1.0;
  vec2 shift = (across * side * width + along * (corner < 2 ? -0.3 : 0.3) * width) / screen;
  gl_Position = end + vec4(shift * end.w, -0.0006 * end.w, 0.0);
  ink = paint;
}`;

const LINE_FRAGMENT = `#version 300 es
precision mediump float;
in vec4 ink; out vec4 colour;
void main() { colour = ink; }`;

const MARK_VERTEX = `#version 300 es
uniform mat4 view;
in vec3 place; in vec4 paint; in float size; in float shape;
out vec4 ink; out float form;
void main() {
  gl_Position = view * vec4(place, 1.0);
  gl_Position.z -= 0.002 * gl_Position.w;
  gl_PointSize = size; ink = paint; form = shape;
}`;

const MARK_FRAGMENT = `#version 300 es
precision highp float;
uniform sampler2D labels; uniform float labelCount;
in vec4 ink; in float form; out vec4 colour;
void main() {
  vec2 at = 2.0 * gl_PointCoord - 1.0;
  float reach = length(at);
  float edge = 0.8;
  bool isStar = form > 0.5 && form < 1.5;
  bool isNumbered = form > 9.5;
  float body = floor((form - 9.5) / labelCount), number = form - 10.0 - body * labelCount;
  if (form > 1.5 && !isNumbered || isNumbered && body > 1.5) reach = 0.82 * (abs(at.x) + abs(at.y));
  else if (isNumbered && body > 0.5) reach = 1.15 * max(abs(at.x), abs(at.y));
  if (isStar) {
    float turn = atan(at.x, -at.y), part = 1.2566370614;
    float fold = abs(mod(turn + 0.5 * part, part) - 0.5 * part) / (0.5 * part);
    edge = mix(0.86, 0.42, fold);
  }
  if (reach > edge + 0.14) discard;
  // Two rims, so that one of them stands out whatever the ground: a white one in a dark one, or the other way round.
  vec3 inner = isStar ? vec3(1.0) : vec3(0.07), outer = isStar ? vec3(0.07) : vec3(1.0);
  colour = vec4(reach > edge + 0.05 ? outer : reach > edge - 0.06 ? inner : ink.rgb, ink.a);
  if (isNumbered && reach < edge - 0.06) {
    float label = texture(labels, vec2((number + gl_PointCoord.x) / labelCount, gl_PointCoord.y)).a;
    colour.rgb = mix(colour.rgb, vec3(0.07), label);
  }
}`;

const rgba = (hex, alpha = 1) => [1, 3, 5].map((at) => Number.parseInt(hex.slice(at, at + 2), 16) / 255).concat(alpha);

/** Column-major products and cameras, no more than is needed. */
function product(a, b) {
  const out = new Float32Array(16);
  for (let column = 0; column < 4; column += 1) {
    for (let row = 0; row < 4; row += 1) {
      for (let n = 0; n < 4; n += 1) out[4 * column + row] += a[4 * n + row] * b[4 * column + n];
    }
  }
  return out;
}

function perspective(angle, aspect, near, far) {
  const f = 1 / Math.tan(angle / 2);
  return new Float32Array([f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, (far + near) / (near - far), -1, 0, 0, (2 * far * near) / (near - far), 0]);
}

function lookAt(eye, target) {
  const norm = (v) => { const l = Math.hypot(...v) || 1; return v.map((c) => c / l); };
  const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const back = norm(eye.map((c, n) => c - target[n]));
  const right = norm(cross([0, 0, 1], back));
  const up = cross(back, right);
  return new Float32Array([right[0], up[0], back[0], 0, right[1], up[1], back[1], 0, right[2], up[2], back[2], 0, -dot(right, eye), -dot(up, eye), -dot(back, eye), 1]);
}

export class SpaceView {
  constructor(canvas, history, map, onChange) {
    Object.assign(this, { canvas, history, map, onChange, yaw: -0.5, pitch: 0.85, distance: 1, shownAt: null });
    this.drawn = { calls: 0, triangles: 0 };
    this.listen();
  }

  /** Whether this browser can show it; tried once. */
  open() {
    if (this.gl !== undefined) return Boolean(this.gl);
    this.gl = this.canvas.getContext("webgl2", { antialias: true, preserveDrawingBuffer: false });
    if (!this.gl) return false;
    const { gl } = this;
    this.ground = this.program(GROUND_VERTEX, GROUND_FRAGMENT);
    this.lines = this.program(LINE_VERTEX, LINE_FRAGMENT);
    this.marks = this.program(MARK_VERTEX, MARK_FRAGMENT);
    this.lineData = gl.createBuffer();
    this.markData = gl.createBuffer();
    this.indices = gl.createBuffer();
    this.labels = this.labelTexture();
    gl.enable(gl.DEPTH_TEST);
    gl.enable(gl.BLEND);
    gl.blendFunc(gl.SRC_ALPHA, gl.ONE_MINUS_SRC_ALPHA);
    return true;
  }

  /** The labels of marks, side by side. */
  labelTexture() {
    const { gl } = this;
    const side = 64;
    const image = new OffscreenCanvas(side * LABELS.length, side);
    const pen = image.getContext("2d");
    pen.font = `700 ${0.56 * side}px system-ui, sans-serif`;
    [pen.textAlign, pen.textBaseline] = ["center", "middle"];
    LABELS.forEach((label, n) => pen.fillText(label, (n + 0.5) * side, 0.53 * side));
    const made = gl.createTexture();
    gl.bindTexture(gl.TEXTURE_2D, made);
    gl.texImage2D(gl.TEXTURE_2D, 0, gl.RGBA, gl.RGBA, gl.UNSIGNED_BYTE, image);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.LINEAR);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_S, gl.CLAMP_TO_EDGE);
    gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_WRAP_T, gl.CLAMP_TO_EDGE);
    return made;
  }

  program(vertex, fragment) {
    const { gl } = this;
    const program = gl.createProgram();
    for (const [kind, text] of [[gl.VERTEX_SHADER, vertex], [gl.FRAGMENT_SHADER, fragment]]) {
      const shader = gl.createShader(kind);
      gl.shaderSource(shader, text);
      gl.compileShader(shader);
      if (!gl.getShaderParameter(shader, gl.COMPILE_STATUS)) throw new Error(gl.getShaderInfoLog(shader));
      gl.attachShader(program, shader);
    }
    gl.linkProgram(program);
    return program;
  }

  /** A new mission: the mesh, and textures that are filled as the ground is seen. */
  begin() {
    this.run = null;
  }

  prepare() {
    const { gl, history } = this;
    const { width, height } = history;
    const strip = new Uint32Array((height - 1) * (2 * width + 1));
    let n = 0;
    for (let y = 0; y + 1 < height; y += 1) {
      for (let x = 0; x < width; x += 1) {
        strip[n] = (y + 1) * width + x;
        strip[n + 1] = y * width + x;
        n += 2;
      }
      strip[n] = 0xffffffff;
      n += 1;
    }
    this.corners = strip.length;
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.indices);
    gl.bufferData(gl.ELEMENT_ARRAY_BUFFER, strip, gl.STATIC_DRAW);
    gl.deleteTexture(this.heights ?? null);
    gl.deleteTexture(this.colours ?? null);
    const texture = (format) => {
      const made = gl.createTexture();
      gl.bindTexture(gl.TEXTURE_2D, made);
      gl.texStorage2D(gl.TEXTURE_2D, 1, format, width, height);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MIN_FILTER, gl.NEAREST);
      gl.texParameteri(gl.TEXTURE_2D, gl.TEXTURE_MAG_FILTER, gl.NEAREST);
      return made;
    };
    this.heights = texture(gl.R32F);
    this.colours = texture(gl.RGBA8);
    this.rows = new Uint32Array(width * height);
    this.run = history.mission.run;
    this.isNew = true;
  }

  /** Passes on the rows that are new on the map. */
  upload() {
    const { gl, history, map } = this;
    const dirty = map.takeDirty();
    if (!dirty && !this.isNew) return;
    const { width, height } = history;
    const [bottom, top] = this.isNew ? [0, height - 1] : [dirty.bottom, dirty.top];
    this.isNew = false;
    for (let y = bottom; y <= top; y += 1) {
      // The map's layer has north at the top, the texture south.
      this.rows.set(map.pixels.subarray((height - 1 - y) * width, (height - y) * width), y * width);
    }
    const [from, until] = [bottom * width, (top + 1) * width];
    gl.bindTexture(gl.TEXTURE_2D, this.colours);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, bottom, width, top - bottom + 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(this.rows.buffer, 4 * from, 4 * (until - from)));
    gl.bindTexture(gl.TEXTURE_2D, this.heights);
    gl.texSubImage2D(gl.TEXTURE_2D, 0, 0, bottom, width, top - bottom + 1, gl.RED, gl.FLOAT, history.heights.subarray(from, until));
  }

  /** How much heights are raised, in cells a metre. */
  raise() {
    const { history, map } = this;
    const cell = history.mission.grid.cell_size_m;
    const range = Math.max(map.range[1] - map.range[0], 1e-6) / cell;
    const wanted = (RELIEF * Math.max(history.width, history.height)) / range;
    this.raised = Math.min(Math.max(wanted, 1), RAISED_MAX);
    return this.raised / cell;
  }

  draw(at, policy) {
    if (!this.open()) return;
    const { gl, history, map, canvas } = this;
    if (this.run !== history.mission.run) this.prepare();
    this.upload();
    const ratio = window.devicePixelRatio || 1;
    const [wide, tall] = [Math.round(canvas.clientWidth * ratio), Math.round(canvas.clientHeight * ratio)];
    if (canvas.width !== wide || canvas.height !== tall) [canvas.width, canvas.height] = [wide, tall];
    const back = rgba(colour("panel"));
    gl.viewport(0, 0, wide, tall);
    gl.clearColor(...back.slice(0, 3), 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    const raise = this.raise();
    const span = Math.max(history.width, history.height);
    const pose = history.pose(at);
    const middle = map.options.follow ? pose.cell : [(history.width - 1) / 2, (history.height - 1) / 2];
    // Whoever looks from above at an angle sees the farther half smaller: the eye is on what is nearer.
    const nearer = map.options.follow ? 0 : 0.07 * span;
    const target = [middle[0] + nearer * Math.sin(this.yaw), middle[1] - nearer * Math.cos(this.yaw), 0.5 * (map.range[0] + map.range[1]) * raise];
    // Far enough for the whole map in the narrower angle of view, however it is turned.
    const halfAngle = Math.min(VIEW_ANGLE / 2, Math.atan(Math.tan(VIEW_ANGLE / 2) * wide / Math.max(tall, 1)));
    const whole = Math.hypot(history.width, history.height) * 0.46 / Math.sin(halfAngle);
    const reach = this.distance * (map.options.follow ? Math.min(span, 90) : whole);
    const eye = [
      target[0] + reach * Math.cos(this.pitch) * Math.sin(this.yaw),
      target[1] - reach * Math.cos(this.pitch) * Math.cos(this.yaw),
      target[2] + reach * Math.sin(this.pitch),
    ];
    const view = product(perspective(VIEW_ANGLE, wide / Math.max(tall, 1), reach / 50, reach * 4 + span * 2), lookAt(eye, target));
    this.drawn = { calls: 0, triangles: 0 };
    this.drawGround(view, raise);
    const key = [history.mission.run, at, history.seen, history.waysKnown, raise, policy?.decision, this.pole(), history.status?.progress?.decision, colour("text")].join();
    if (this.lineKey !== key) {
      this.lineKey = key;
      this.segments = this.routeLines(at, raise, policy);
      gl.bindBuffer(gl.ARRAY_BUFFER, this.lineData);
      gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(this.segments), gl.DYNAMIC_DRAW);
    }
    this.drawLines(view, [wide, tall], this.segments.length / 11);
    this.drawMarks(view, this.symbols(at, raise, ratio));
    this.canvas.dataset.drawn = `${this.drawn.calls} calls, ${this.drawn.triangles} triangles`;
  }

  drawGround(view, raise) {
    const { gl, history, map } = this;
    const place = (name) => gl.getUniformLocation(this.ground, name);
    gl.useProgram(this.ground);
    gl.uniformMatrix4fv(place("view"), false, view);
    gl.uniform2i(place("size"), history.width, history.height);
    gl.uniform1f(place("raise"), raise);
    gl.uniform1f(place("floorHeight"), map.range[0]);
    // Lighter or darker than what is behind it, whatever the theme.
    const [unseen, dim] = [rgba(colour("unseen")), rgba(colour("dim"))];
    gl.uniform3f(place("fog"), ...[0, 1, 2].map((n) => 0.66 * unseen[n] + 0.34 * dim[n]));
    gl.activeTexture(gl.TEXTURE0); gl.bindTexture(gl.TEXTURE_2D, this.heights); gl.uniform1i(place("heights"), 0);
    gl.activeTexture(gl.TEXTURE1); gl.bindTexture(gl.TEXTURE_2D, this.colours); gl.uniform1i(place("colours"), 1);
    gl.activeTexture(gl.TEXTURE0);
    for (let n = 0; n < 8; n += 1) gl.disableVertexAttribArray(n);
    gl.bindBuffer(gl.ELEMENT_ARRAY_BUFFER, this.indices);
    gl.drawElements(gl.TRIANGLE_STRIP, this.corners, gl.UNSIGNED_INT, 0);
    this.count(2 * (history.width - 1) * (history.height - 1));
  }

  count(triangles) {
    this.drawn.calls += 1;
    this.drawn.triangles += triangles;
  }

  /** Height of a cell in space, a little above the ground. */
  over([x, y], raise, above = 0.12) {
    const { history, map } = this;
    const isSeen = history.inside([x, y]) && history.seenAt[y * history.width + x] <= map.shownAt;
    return (isSeen ? history.heights[y * history.width + x] : map.range[0]) * raise + above;
  }

  /** A place of a way in space, [x, y] in cells from the south-western corner and metres of height; never below the ground that was seen. */
  spot([x, y, z], raise, above = 0.12) {
    const { history, map } = this;
    const [left, bottom] = [Math.floor(x - 0.5), Math.floor(y - 0.5)];
    const [right, up] = [x - 0.5 - left, y - 0.5 - bottom];
    let ground = 0;
    for (const [dx, dy, share] of [[0, 0, (1 - right) * (1 - up)], [1, 0, right * (1 - up)], [0, 1, (1 - right) * up], [1, 1, right * up]]) {
      const cell = [left + dx, bottom + dy];
      const isSeen = history.inside(cell) && history.seenAt[cell[1] * history.width + cell[0]] <= map.shownAt;
      ground += share * (isSeen ? history.heights[cell[1] * history.width + cell[0]] : z);
    }
    return [x - 0.5, y - 0.5, Math.max(z, ground) * raise + above];
  }

  /** Height of the robots that fly, in cells. */
  cruise(raise) {
    return this.map.range[1] * raise + Math.max(CRUISE * Math.max(this.history.width, this.history.height), 1);
  }

  /** The last hops, drives and flights, and the route that the policy expects, as segments. */
  routeLines(at, raise, policy) {
    const { history, map } = this;
    const data = [];
    const line = (a, b, paint, width) => data.push(...a, ...b, ...paint, width);
    const [alone, stray, rolled] = [rgba(ROUTE), rgba(STRAY), rgba(ROLLED)];
    for (const hop of history.robots > 1 ? map.trailOf(at) : history.hopsUntil(at, ARCS)) {
      const { body } = history.mission.robots[hop.robot];
      const own = history.robots > 1 ? rgba(robotColour(hop.robot)) : alone;
      const way = history.wayOf(hop);
      if (way) {
        for (const stretch of way.stretches) {
          const ink = stretch.climbMps === null ? rolled : hop.stray ? stray : own;
          const points = Array.from({ length: SEGMENTS + 1 }, (_, part) => this.spot(placeOn(stretch, part / SEGMENTS).place, raise));
          for (let part = 0; part < SEGMENTS; part += 1) line(points[part], points[part + 1], ink, 3);
        }
        continue;
      }
      const lengthCells = Math.hypot(hop.to[0] - hop.from[0], hop.to[1] - hop.from[1]);
      if (hop.branch === "held" || lengthCells === 0) continue;
      const between = (share) => [0, 1].map((axis) => hop.from[axis] + (hop.to[axis] - hop.from[axis]) * share);
      if (body === "helicopter") {
        line([...hop.from, this.cruise(raise)], [...hop.to, this.cruise(raise)], own, 3);
        continue;
      }
      const drives = body === "driver" || body === "rover";
      const [low, high] = [this.over(hop.from, raise), this.over(hop.to, raise)];
      const along = (share) => {
        const place = between(share);
        if (drives) return [...place, this.over(place.map(Math.round), raise, 0.25)];
        return [...place, low + (high - low) * share + 0.5 * lengthCells * 4 * share * (1 - share)];
      };
      const parts = drives ? Math.ceil(lengthCells) : SEGMENTS;
      for (let part = 0; part < parts; part += 1) line(along(part / parts), along((part + 1) / parts), hop.stray ? stray : own, 3);
    }
    if (history.robots > 1) {
      // A line down from each robot that flies, and the poles of goals.
      history.poses(at).forEach(({ cell }, robot) => {
        const { body, goals } = history.mission.robots[robot];
        const ink = rgba(robotColour(robot));
        if (cell && body === "helicopter") line([...cell, this.over(cell, raise)], [...cell, this.cruise(raise)], ink, 1.5);
        for (const [x, y] of goals) {
          const foot = this.over([Math.floor(x), Math.floor(y)], raise);
          line([x - 0.5, y - 0.5, foot], [x - 0.5, y - 0.5, foot + this.pole()], rgba(colour("text")), 2.5);
        }
      });
    }
    if (policy) {
      const cells = map.expected(policy, history.pose(at).cell, at);
      for (let n = 1; n < cells.length; n += 1) {
        const [a, b] = [cells[n - 1], cells[n]];
        line([...a, this.over(a, raise, 0.2)], [...b, this.over(b, raise, 0.2)], rgba(colour("text"), 0.85), 2);
      }
    }
    const goal = history.robots > 1 ? null : history.goal(at);
    if (!goal) return data;
    const foot = this.over(goal, raise);
    line([...goal, foot], [...goal, foot + this.pole()], rgba(colour("text")), 2.5);
    return data;
  }

  pole() {
    // Above the number of a robot that stands at its foot.
    const share = this.history.robots > 1 ? 0.1 : 0.06;
    return Math.max(share * Math.max(this.history.width, this.history.height) * Math.min(this.distance, 1), 1.2);
  }

  drawLines(view, screen, count) {
    if (count === 0) return;
    const { gl } = this;
    gl.useProgram(this.lines);
    gl.uniformMatrix4fv(gl.getUniformLocation(this.lines, "view"), false, view);
    gl.uniform2f(gl.getUniformLocation(this.lines, "screen"), ...screen);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.lineData);
    this.attributes(this.lines, [["from", 3], ["to", 3], ["paint", 4], ["width", 1]], 1);
    gl.drawArraysInstanced(gl.TRIANGLE_STRIP, 0, 4, count);
    this.count(2 * count);
  }

  symbols(at, raise, ratio) {
    const { history } = this;
    const data = [];
    const mark = ([x, y], above, hex, size, shape) => data.push(x, y, this.over([x, y], raise, above), ...rgba(hex), size * ratio, shape);
    if (history.robots > 1) {
      history.poses(at).forEach(({ cell, standing }, robot) => {
        const { body, start, goals } = history.mission.robots[robot];
        const ink = rgba(robotColour(robot));
        if (body !== "rover") data.push(start[0] - 0.5, start[1] - 0.5, this.over(start.map(Math.floor), raise, 0.3), ...ink, 11 * ratio, 0);
        for (const [x, y] of goals) data.push(x - 0.5, y - 0.5, this.over([Math.floor(x), Math.floor(y)], raise, this.pole() + 0.12), ...ink, 26 * ratio, 1);
        if (!cell) return;
        const height = body === "helicopter" ? this.cruise(raise) : this.over(cell, raise, 0.5);
        data.push(...cell, height, ...ink, 26 * ratio, NUMBERED + LABELS.length * SHAPES[body] + (standing === "stranded" ? LABELS.length - 1 : robot));
      });
      return data;
    }
    mark(history.mission.start, 0.3, START, 16, 0);
    const goal = history.goal(at);
    if (goal) mark(goal, this.pole() + 0.12, GOAL, 30, 1);
    const flight = this.map.flightAt(at);
    const pose = history.pose(at);
    for (const impact of this.impacts(flight ? at - 1 : at)) data.push(...this.spot(impact, raise), ...rgba(IMPACT), 11 * ratio, 2);
    if (flight?.way) {
      const { way, share } = flight;
      for (const impact of way.impacts) if (impact.seconds <= share * way.seconds) data.push(...this.spot(impact.at, raise), ...rgba(IMPACT), 11 * ratio, 2);
      data.push(...this.spot(way.at(share * way.seconds).place, raise, 0.25), ...rgba(HOPPER), 18 * ratio, 0);
      this.onChange();
    } else if (flight) {
      const { hop, share } = flight;
      const place = [0, 1].map((n) => hop.from[n] + (hop.to[n] - hop.from[n]) * share);
      const height = this.over(hop.from, raise, 0.5) * (1 - share) + this.over(hop.to, raise, 0.5) * share;
      data.push(...place, height + 0.5 * Math.hypot(hop.to[0] - hop.from[0], hop.to[1] - hop.from[1]) * 4 * share * (1 - share), ...rgba(HOPPER), 18 * ratio, 0);
      this.onChange();
    } else {
      const way = history.inside(pose.cell) ? history.wayOf(history.hopperHopBefore(at)) : null;
      if (way) data.push(...this.spot(way.rest, raise, 0.25), ...rgba(HOPPER), 18 * ratio, 0);
      else mark(pose.cell, 0.5, HOPPER, 18, 0);
    }
    return data;
  }

  /** Where the last hops before a moment hit the ground. */
  impacts(at) {
    const { history } = this;
    const found = [];
    if (history.ways.size === 0) return found;
    for (const hop of history.hopsUntil(at, ARCS).reverse()) {
      if (found.length >= IMPACTS) break;
      found.push(...(history.wayOf(hop)?.impacts ?? []).map((impact) => impact.at));
    }
    return found;
  }

  drawMarks(view, data) {
    const { gl } = this;
    gl.useProgram(this.marks);
    gl.uniformMatrix4fv(gl.getUniformLocation(this.marks, "view"), false, view);
    gl.uniform1i(gl.getUniformLocation(this.marks, "labels"), 0);
    gl.uniform1f(gl.getUniformLocation(this.marks, "labelCount"), LABELS.length);
    gl.bindTexture(gl.TEXTURE_2D, this.labels);
    gl.bindBuffer(gl.ARRAY_BUFFER, this.markData);
    gl.bufferData(gl.ARRAY_BUFFER, new Float32Array(data), gl.DYNAMIC_DRAW);
    this.attributes(this.marks, [["place", 3], ["paint", 4], ["size", 1], ["shape", 1]], 0);
    gl.drawArrays(gl.POINTS, 0, data.length / 9);
    this.count(0);
  }

  attributes(program, fields, divisor) {
    const { gl } = this;
    const stride = 4 * fields.reduce((sum, [, size]) => sum + size, 0);
    for (let n = 0; n < 8; n += 1) gl.disableVertexAttribArray(n);
    let offset = 0;
    for (const [name, size] of fields) {
      const at = gl.getAttribLocation(program, name);
      gl.enableVertexAttribArray(at);
      gl.vertexAttribPointer(at, size, gl.FLOAT, false, stride, offset);
      gl.vertexAttribDivisor(at, divisor);
      offset += 4 * size;
    }
  }

  listen() {
    const { canvas } = this;
    let dragged = null;
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      dragged = [event.offsetX, event.offsetY];
    });
    canvas.addEventListener("pointermove", (event) => {
      if (!dragged) return;
      this.yaw -= (event.offsetX - dragged[0]) / 180;
      this.pitch = Math.min(Math.max(this.pitch + (event.offsetY - dragged[1]) / 220, 0.12), 1.5);
      dragged = [event.offsetX, event.offsetY];
      this.onChange();
    });
    const end = () => { dragged = null; };
    canvas.addEventListener("pointerup", end);
    canvas.addEventListener("pointercancel", end);
    canvas.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.magnify(2 ** (-event.deltaY / 300));
    }, { passive: false });
  }

  magnify(factor) {
    this.distance = Math.min(Math.max(this.distance / factor, 0.1), 3);
    this.onChange();
  }
}
