// Light, dark, contrast: what the page's colours are.

const root = document.documentElement;
const stored = (name) => { try { return localStorage.getItem(name); } catch { return null; } };
const store = (name, value) => { try { localStorage.setItem(name, value); } catch { /* private mode */ } };
const prefers = (query) => window.matchMedia(query).matches;

let colours = new Map();

/** A colour of the page by its name, as CSS has it. */
export function colour(name) {
  if (!colours.has(name)) colours.set(name, getComputedStyle(root).getPropertyValue(`--${name}`).trim());
  return colours.get(name);
}

export function isLight() {
  return root.dataset.theme === "light";
}

export function isStark() {
  return root.dataset.contrast === "more";
}

function set(name, value) {
  root.dataset[name] = value;
  colours = new Map();
}

export function begin() {
  set("theme", stored("hopper.theme") ?? (prefers("(prefers-color-scheme: light)") ? "light" : "dark"));
  set("contrast", stored("hopper.contrast") ?? (prefers("(prefers-contrast: more)") ? "more" : "plain"));
}

export function toggleTheme() {
  set("theme", isLight() ? "dark" : "light");
  store("hopper.theme", root.dataset.theme);
}

export function toggleContrast() {
  set("contrast", isStark() ? "plain" : "more");
  store("hopper.contrast", root.dataset.contrast);
}
