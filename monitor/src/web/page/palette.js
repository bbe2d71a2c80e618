// The colours of the map: those of the pictures that `crates/report/src/colour.rs` draws, on every theme.

/** Hops that landed as aimed. */
export const ROUTE = "#005f8f";
/** Hops that slipped or stayed. */
export const STRAY = "#e3000f";
/** What a body rolled, and where it hit the ground. */
export const ROLLED = "#6a2fa0";
export const IMPACT = "#ffffff";
/** Sand: a tint, and the dots over it. */
export const SAND = "#7d8288";
/** Impassable ground. */
export const BLOCKED = "#22262e";
/** Start, hopper, goal. */
export const START = "#1f6fe0";
export const HOPPER = "#ffd400";
export const GOAL = "#e3000f";
/** Robots by their numbers, as far as they are told apart by colour; each also has its number. */
const ROBOTS = ["#ffd400", "#1f9fe0", "#ff8a3d", "#7fd069", "#c98be8", "#f26d9a", "#4fd0c0", "#c9b458"];
export const robotColour = (robot) => ROBOTS[robot % ROBOTS.length];
/** Treasures: seen, collected. */
export const TREASURE = "#111111";
export const COLLECTED = "#ffc400";
/** Rims that make a symbol stand out on every ground. */
export const DARK = "#111111";
export const LIGHT = "#ffffff";

/** A height at `share` of the scale, 0 to 1, as [r, g, b]: from umber to cream in OkLCh. */
function height(share) {
  const lightness = 0.55 + 0.42 * share;
  const chroma = 0.080 + 0.025 * (1 - share) * share * 4 - 0.035 * share;
  const hue = ((48 + 47 * share) * Math.PI) / 180;
  const [a, b] = [chroma * Math.cos(hue), chroma * Math.sin(hue)];
  const long = (lightness + 0.3963377774 * a + 0.2158037573 * b) ** 3;
  const medium = (lightness - 0.1055613458 * a - 0.0638541728 * b) ** 3;
  const short = (lightness - 0.0894841775 * a - 1.291485548 * b) ** 3;
  return [
    4.0767416621 * long - 3.3077115913 * medium + 0.2309699292 * short,
    -1.2684380046 * long + 2.6097574011 * medium - 0.3413193965 * short,
    -0.0041960863 * long - 0.7034186147 * medium + 1.707614701 * short,
  ].map((linear) => {
    const clipped = Math.min(Math.max(linear, 0), 1);
    return 255 * (clipped <= 0.0031308 ? 12.92 * clipped : 1.055 * clipped ** (1 / 2.4) - 0.055);
  });
}

/** Heights in 64 steps, lowest first. */
export const GROUND = Array.from({ length: 64 }, (_, n) => height(n / 63));
/** Values of a policy, in the manner of viridis, worst first. */
export const VALUES = [[68, 1, 84], [65, 68, 135], [42, 120, 142], [34, 168, 132], [122, 209, 81], [253, 231, 37]];

/** A colour of a ramp at `share`, 0 to 1. */
export function ramp(colours, share) {
  const place = Math.min(Math.max(share, 0), 1) * (colours.length - 1);
  const n = Math.min(Math.floor(place), colours.length - 2);
  return colours[n].map((low, band) => low + (colours[n + 1][band] - low) * (place - n));
}
