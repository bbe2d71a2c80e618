// Numbers as people read them, and the axes they stand on.

/** A duration in the unit that suits it. */
export function duration(us) {
  if (us < 1) return "0 µs";
  if (us < 999.5) return `${us.toFixed(us < 9.95 ? 1 : 0)} µs`;
  const [value, unit] = us < 999500 ? [us / 1e3, "ms"] : [us / 1e6, "s"];
  return `${value.toFixed(value < 9.95 ? 1 : 0)} ${unit}`;
}

/** A number with so many digits after the point, and a sign only if it is not zero. */
export function fixed(value, digits) {
  const text = value.toFixed(digits);
  return Number(text) === 0 ? text.replace("-", "") : text.replace("-", "−");
}

/** Seconds in a Sol, a day of Mars. */
const SOL_S = 88775.244;

/** Simulated time in words: in Sols from one Sol on, if that is what the mission counts in. */
export function missionTime(seconds, inSols) {
  if (seconds < 60) return `${seconds.toFixed(1)} s`;
  if (inSols && seconds >= SOL_S) return `${(seconds / SOL_S).toFixed(2)} Sols`;
  const minutes = Math.floor(seconds / 60);
  if (seconds < 3600) return `${minutes} min ${Math.floor(seconds % 60)} s`;
  return `${Math.floor(minutes / 60)} h ${minutes % 60} min`;
}

/** An axis over durations, logarithmic from 10 µs or linear from 0, `length` pixels long. */
export class TimeAxis {
  constructor(length, longestUs, logarithmic) {
    this.length = length;
    this.logarithmic = logarithmic;
    this.low = 10;
    this.high = logarithmic ? Math.max(1.3e6, longestUs * 1.5) : Math.max(1, longestUs * 1.08);
  }

  at(us) {
    if (!this.logarithmic) return (Math.min(us, this.high) / this.high) * this.length;
    const share = Math.log(Math.max(us, this.low) / this.low) / Math.log(this.high / this.low);
    return Math.min(share, 1) * this.length;
  }

  holds(us) {
    return us <= this.high;
  }

  ticks() {
    if (this.logarithmic) {
      const ticks = [];
      for (let us = this.low; us <= this.high; us *= 10) ticks.push(us);
      return ticks;
    }
    const rough = this.high / 4;
    const unit = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map((n) => n * unit).find((n) => n >= rough);
    return Array.from({ length: Math.floor(this.high / step) + 1 }, (_, n) => n * step);
  }
}

/** The tick's name: short, without needless digits. */
export function tick(us) {
  if (us === 0) return "0";
  const [value, unit] = us < 1e3 ? [us, "µs"] : us < 1e6 ? [us / 1e3, "ms"] : [us / 1e6, "s"];
  return `${Number(value.toPrecision(3))} ${unit}`;
}

/** Fits a canvas to its place on the page, whatever the screen's density; its context in page pixels. */
export function fitted(canvas) {
  const ratio = window.devicePixelRatio || 1;
  const { clientWidth: width, clientHeight: height } = canvas;
  const [columns, rows] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== columns || canvas.height !== rows) [canvas.width, canvas.height] = [columns, rows];
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  return { context, width, height };
}
