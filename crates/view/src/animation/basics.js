// Numbers and their text.

const clamp = (value, low, high) => Math.min(Math.max(value, low), high);
const round = (value) => Math.round(value * 100) / 100;
const PREFIXES = { "-12": "p", "-9": "n", "-6": "µ", "-3": "m", 0: "", 3: "k", 6: "M", 9: "G", 12: "T" };

/** The power of ten, a multiple of three, to divide numbers by; between `low` and `high` they are left as they are. */
function exponentFor(largest, low, high) {
  if (!(largest > 0) || (largest >= low && largest < high)) return 0;
  return clamp(3 * Math.floor(Math.log10(largest) / 3 + 1e-9), -12, 12);
}

/** With a true minus sign, and no minus before zero. */
function fixed(value, decimals) {
  const text = Math.abs(value).toFixed(clamp(decimals, 0, 12));
  return value < 0 && Number(text) !== 0 ? "\u2212" + text : text;
}

/** The round number of the series 1, 2, 5 that is not below a positive one. */
function nice(value) {
  const power = 10 ** Math.floor(Math.log10(value));
  return [1, 2, 5, 10].find((factor) => factor * power >= value * 0.999999) * power;
}

const decimalsOf = (step) => Math.max(0, -Math.floor(Math.log10(step) + 1e-9));

/** Multiples of a step from low to high. */
function multiples(low, high, step) {
  const first = Math.ceil(low / step - 1e-6);
  const count = clamp(Math.floor(high / step + 1e-6) - first + 1, 0, 100);
  return Array.from({ length: count }, (_, place) => (first + place) * step);
}

/** The smallest and the largest of the finite numbers. */
function rangeOf(lists) {
  let [low, high] = [Infinity, -Infinity];
  for (const list of lists) {
    for (const value of list) {
      if (value < low) low = value;
      if (value > high) high = value;
    }
  }
  return low <= high ? [low, high] : [0, 0];
}

// Values between frames.

/** The frame before a time, and how far it is to the next one. */
function locate(times, time) {
  let [low, high] = [0, times.length - 1];
  while (high - low > 1) {
    const middle = (low + high) >> 1;
    if (times[middle] <= time) low = middle;
    else high = middle;
  }
  const span = times[high] - times[low];
  return { frame: low, part: span > 0 ? clamp((time - times[low]) / span, 0, 1) : 0 };
}

function valueAt(track, at) {
  if (track.length === 1) return track[0];
  const value = track[at.frame];
  return at.part === 0 ? value : value + (track[at.frame + 1] - value) * at.part;
}

/** Angles may jump by whole turns between frames; the short way is meant. */
function angleAt(track, at) {
  if (track.length === 1) return track[0];
  const turn = track[Math.min(at.frame + 1, track.length - 1)] - track[at.frame];
  return track[at.frame] + (turn - 2 * Math.PI * Math.round(turn / (2 * Math.PI))) * at.part;
}

// Elements.

function element(parent, name, attributes = {}, text = "") {
  const child = document.createElementNS("http://www.w3.org/2000/svg", name);
  for (const key in attributes) child.setAttribute(key, attributes[key]);
  // Names are only ever put in as text.
  if (text) child.textContent = text;
  parent.append(child);
  return child;
}

function html(parent, name, style, text = "") {
  const child = document.createElement(name);
  if (style) child.className = style;
  if (text) child.textContent = text;
  parent.append(child);
  return child;
}
