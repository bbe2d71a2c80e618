// The way of a hop whose motion is physical: flights, impacts, rolling and the exact place of rest.

/** Degrees of a radian. */
const DEGREES = 180 / Math.PI;

/** What the motion model told of a hop. Places are [x, y, z]: cells from the south-western corner of the map, and metres above the datum. */
export class Way {
  constructor({ detail, stretches, ended, lost_j_per_kg: lostJPerKg }, names, cellM) {
    const place = ([east, north, up]) => [east / cellM, north / cellM, up];
    Object.assign(this, { ended, lostJPerKg, model: detail.model });
    this.told = Object.fromEntries(names.map((name, n) => [name, detail.figures[n]]));
    this.rest = place(detail.rest_m);
    this.impacts = detail.path.slice(1).map((point) => ({ seconds: point.seconds, at: place(point.at_m) }));
    this.launch = detail.path[0] ? { at: place(detail.path[0].at_m), mps: detail.path[0].leaves_mps } : null;
    this.stretches = stretches.map((one) => ({ begins: one.begins_s, ends: one.ends_s, from: place(one.from_m), to: place(one.to_m), climbMps: one.climb_mps, isLast: one.last }));
    /** From the launch to rest. */
    this.seconds = this.stretches.at(-1)?.ends ?? 0;
  }

  /** Speed of the launch, m/s. */
  get speedMps() {
    return Math.hypot(...this.launch.mps);
  }

  /** How steep the launch was above the level, degrees. */
  get angleDeg() {
    const [east, north, up] = this.launch.mps;
    return Math.atan2(up, Math.hypot(east, north)) * DEGREES;
  }

  /** The direction in which it was launched, as steps of a cell: that of the four which is nearest. */
  get step() {
    if (!this.launch) return null;
    const [east, north] = this.launch.mps;
    if (east === 0 && north === 0) return null;
    return Math.abs(east) >= Math.abs(north) ? [Math.sign(east), 0] : [0, Math.sign(north)];
  }

  /** Where the body is so many seconds after the launch, and how high above the chord of its flight, metres. */
  at(seconds) {
    const stretch = this.stretches.find(({ ends }) => seconds <= ends);
    if (!stretch) return { place: this.rest, liftM: 0 };
    const { begins, ends } = stretch;
    return placeOn(stretch, ends > begins ? Math.max(seconds - begins, 0) / (ends - begins) : 1);
  }
}

/** Where the body is at a share of the time of a stretch: as `Stretch::at` of the crate `report`. */
export function placeOn({ begins, ends, from, to, climbMps, isLast }, share) {
  const flies = climbMps !== null;
  // The last roll slows down evenly.
  const part = flies || !isLast ? share : share * (2 - share);
  const place = from.map((value, axis) => value + (to[axis] - value) * part);
  const liftM = flies ? (climbMps * (ends - begins) - (to[2] - from[2])) * share * (1 - share) : 0;
  place[2] += liftM;
  return { place, liftM };
}
