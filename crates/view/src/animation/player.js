// The controls, and what ties drawing and plots to the time.

const root = document.currentScript.closest(".qrm-animation");
const part = (name) => root.querySelector(`.qrm-${name}`);
const isPage = root.dataset.mode === "page";

let motion = null;
let times = [];
let [begin, end, duration] = [0, 0, 0];
let [timeExponent, timeDecimals] = [0, 3];
let planned = null;
let plots = [];
let drawing = null;
let time = 0;
let speed = 1;
let isPlaying = false;
let isHeld = false;
let isSeen = true;
const timeText = (value) => `${fixed(value / 10 ** timeExponent, timeDecimals)} ${PREFIXES[timeExponent]}s`;

/** JSON knows no numbers that are not finite. A place keeps its last one, a curve has a gap. */
function completed(motion) {
  const kept = (track) => {
    let last = track.find((value) => value !== null) ?? 0;
    return track.map((value) => (last = value ?? last));
  };
  for (const thing of [...motion.nodes, ...motion.arrows]) [thing.x, thing.y] = [kept(thing.x), kept(thing.y)];
  for (const shape of motion.shapes) if (shape.angle) shape.angle = kept(shape.angle);
  for (const { curves } of motion.plots) {
    for (const curve of curves) curve.values = curve.values.map((value) => value ?? NaN);
  }
  return motion;
}

/** Whether the next motion follows within moments. */
let isDraft = false;

/** What is shown of a motion, but for numbers. */
function kind({ nodes, shapes, arrows, plots }, { most }) {
  const names = [nodes, shapes, arrows].map((list) => list.map((each) => [each.kind, each.name, each.is_traced, each.is_reaction]));
  return JSON.stringify([names, plots.map(({ title, curves }) => [title, curves.map((curve) => curve.name)]), most > 0]);
}

let kindShown = "";

/**
 * Shows a motion, at the time that was shown of the one before; of a draft not every detail is looked after. With the
 * plan of another motion the scale of the drawing stays.
 */
function install(next, draft = false, plannedBefore = null) {
  [isDraft, inserted] = [draft, 0];
  motion = completed(next);
  times = motion.times;
  [begin, end] = [times[0], times[times.length - 1]];
  duration = end - begin;
  timeExponent = Math.min(exponentFor(duration, 0.01, Infinity), 0);
  timeDecimals = duration / 10 ** timeExponent < 1000 ? 3 : 1;
  planned = { ...plan(motion), ...(plannedBefore && { box: plannedBefore.box }) };
  const kindNow = kind(motion, planned);
  const isNew = kindNow !== kindShown;
  kindShown = kindNow;
  if (isNew) {
    part("plots").replaceChildren();
    plots = motion.plots.map((data) => plot(part("plots"), data, seek));
    part("plots").hidden = plots.length === 0;
    root.toggleAttribute("data-empty", motion.nodes.length === 0);
    listShapes();
    offerSwitches();
  }
  listAxes();
  setAxis();
  [slider.min, slider.max] = [begin, end];
  listSpeeds();
  time = clamp(time, begin, end);
  if (!draft) {
    const { box } = planned;
    const aspect = clamp((box.right - box.left) / (box.top - box.bottom), 0.8, 2.2);
    part("canvas").style.setProperty("--aspect", aspect.toFixed(3));
  }
  if (isNew) {
    sizes.clear();
    observer.disconnect();
    const areas = [part("canvas"), ...plots.map((each) => each.area)];
    for (const area of areas) observer.observe(area);
    fit(areas);
  } else {
    // Nothing has another size: it need not be asked for.
    for (const target of sizes.keys()) redraw(target);
    show(time);
  }
}

/** What curves are drawn over: the time, or the angle of a link on the ground, in degrees of one turn. */
let axes = [];

function listAxes() {
  const timeAxis = {
    name: "time", exponent: timeExponent, unit: `${PREFIXES[timeExponent]}s`, jump: Infinity,
    range: () => [begin, end], step: (span, count) => nice(span / count), at: (_, time) => time, timeAt: (time) => time,
  };
  const isStill = (id) => motion.nodes[id].x.length + motion.nodes[id].y.length === 2;
  const turning = motion.shapes.filter(({ kind, name, nodes }) => kind === "link" && name && nodes.some(isStill) && !nodes.every(isStill));
  const angleAxis = ({ name, nodes }) => {
    const [still, moving] = [nodes.find(isStill), nodes.find((id) => !isStill(id))].map((id) => motion.nodes[id]);
    const radians = (at) => {
      const [dx, dy] = ["x", "y"].map((axis) => valueAt(moving[axis], at) - valueAt(still[axis], at));
      return Math.atan2(dy, dx);
    };
    // A link that only rocks has the range in which it does.
    const frames = times.map((_, frame) => radians({ frame, part: 0 }));
    let [turned, low, high] = [frames[0], frames[0], frames[0]];
    for (let frame = 1; frame < frames.length; frame++) {
      turned += angleAt(frames, { frame: frame - 1, part: 1 }) - frames[frame - 1];
      [low, high] = [Math.min(low, turned), Math.max(high, turned)];
    }
    [low, high] = [low, high].map((angle) => (angle * 180) / Math.PI);
    const rocks = high - low < 330;
    const from = rocks ? (low + high) / 2 - 180 : 0;
    const at = (at) => ((((radians(at) * 180) / Math.PI - from) % 360) + 360) % 360 + from;
    // The time next to the one shown at which the angle is passed.
    const timeAt = (angle) => {
      const far = (frame) => ((at({ frame, part: 0 }) - angle + 540) % 360) - 180;
      const passes = times.slice(1).flatMap((next, frame) => {
        const [a, b] = [far(frame), far(frame + 1)];
        return a * b <= 0 && Math.abs(a - b) < 180 ? [times[frame] + (next - times[frame]) * (a / (a - b) || 0)] : [];
      });
      return passes.reduce((best, each) => (Math.abs(each - time) < Math.abs(best - time) ? each : best), passes[0] ?? time);
    };
    return { name: `angle of ${name}`, exponent: 0, unit: "deg", jump: 180, range: () => (rocks ? [low, high] : [0, 360]), step: (span, count) => (rocks ? nice(span / count) : count < 8 ? 90 : 60), at, timeAt };
  };
  axes = [timeAxis, ...turning.map(angleAxis)];
  const names = axes.map(({ name }) => name);
  const over = part("over");
  over.parentElement.hidden = names.length < 2 || plots.length === 0;
  if (String([...over.options].map((option) => option.value)) === String(names)) return;
  const chosen = over.value;
  over.replaceChildren();
  for (const name of names) html(over, "option", "", name);
  if (names.includes(chosen)) over.value = chosen;
}

const chosenAxis = () => axes.find(({ name }) => name === part("over").value) ?? axes[0];

/** Gives the curves what they are drawn over. */
function setAxis() {
  const axis = chosenAxis();
  plots.forEach((each, place) => each.setData(motion.plots[place], times, axis));
}
part("over").addEventListener("change", () => {
  setAxis();
  for (const each of plots) if (sizes.has(each.area)) redraw(each.area);
  show(time);
});

/** Computes the numbers of a motion at a time, null if that fails. Without it there are frames alone. */
let numbersAt = null;
/** The place of the frame at the time shown, where one was put in. */
let inserted = 0;

/** All tracks that change, each with its place among the numbers of a time. */
function changing() {
  const pairs = [...motion.nodes, ...motion.arrows].flatMap(({ x, y }) => [x, y]);
  const angles = motion.shapes.flatMap(({ angle }) => (angle ? [angle] : []));
  const values = motion.plots.flatMap(({ curves }) => curves.map((curve) => curve.values));
  return [...pairs, ...angles, ...values].map((track, place) => [track, place]).filter(([track]) => track.length > 1);
}

function removeFrame() {
  if (!inserted) return;
  times.splice(inserted, 1);
  for (const [track] of changing()) track.splice(inserted, 1);
  inserted = 0;
}

/** Puts a frame in at the time shown, so that nothing that is seen there lies between two frames. */
function insertFrame() {
  removeFrame();
  const numbers = isDraft ? null : numbersAt?.(time);
  if (!numbers) return;
  const place = locate(times, time).frame + 1;
  for (const [track, number] of changing()) track.splice(place, 0, numbers[number] ?? NaN);
  times.splice(place, 0, time);
  inserted = place;
}

function show(next) {
  time = clamp(next, begin, end);
  insertFrame();
  drawing?.update(time);
  for (const each of plots) each.update(time);
  part("slider").value = time;
  part("time").textContent = `t = ${timeText(time)}`;
  root.dataset.time = Number(time.toPrecision(9));
  // Speaking out every frame would be noise.
  if (!isPlaying) part("slider").setAttribute("aria-valuetext", timeText(time));
}

const ICONS = {
  back: "M14.5 4.5v11L7 10zM5 4.5h1.6v11H5z",
  play: "M6 3.5v13L16.5 10z",
  pause: "M5 4h3.6v12H5zM11.4 4H15v12h-3.6z",
  forth: "M5.5 4.5v11L13 10zM13.4 4.5H15v11h-1.6z",
};

function setIcon(button, name) {
  part(button).innerHTML = `<svg viewBox="0 0 20 20" aria-hidden="true"><path d="${ICONS[name]}"/></svg>`;
}

for (const name of ["back", "play", "forth"]) setIcon(name, name);
let before = 0;

function play(yes) {
  if (yes === isPlaying || (yes && !(duration > 0))) return;
  isPlaying = yes;
  root.dataset.playing = yes;
  part("play").setAttribute("aria-label", yes ? "Pause" : "Play");
  setIcon("play", yes ? "pause" : "play");
  before = performance.now();
  if (yes) requestAnimationFrame(tick);
  else show(time);
}

function tick(now) {
  if (!isPlaying) return;
  // After a pause of the browser the motion goes on from where it was.
  const passed = clamp(now - before, 0, 250) / 1000;
  before = now;
  if (!isHeld && isSeen) {
    const next = time + passed * speed;
    show(next <= end ? next : begin + ((next - begin) % duration));
  }
  requestAnimationFrame(tick);
}

function seek(next) {
  play(false);
  show(next);
}

/** To the next or the previous recorded frame, round the ends. */
function move(direction) {
  const slack = 1e-9 * duration;
  if (direction > 0) seek(times.find((each) => each > time + slack) ?? begin);
  else seek(times.findLast((each) => each < time - slack) ?? end);
}

// Legend.
const legend = part("legend");
let forceKey = null;
function arrowKey(name, style) {
  const entry = html(legend, "li", style);
  const key = element(entry, "svg", { "aria-hidden": "true", width: 26, height: 10 });
  element(key, "path", { class: "qrm-shaft", d: "M0 5H17" });
  element(key, "path", { class: "qrm-tip", d: "M26 5l-9 3.6v-7.2z" });
  html(entry, "span", "", name);
}

function listShapes() {
  legend.replaceChildren();
  const listed = new Set();
  motion.shapes.forEach((shape, place) => {
    if (planned.colour[place] < 0 || !shape.name || listed.has(shape.name)) return;
    listed.add(shape.name);
    const entry = html(legend, "li", `qrm-c${planned.colour[place]}`);
    html(entry, "i", shape.kind === "block" ? "qrm-swatch qrm-square" : "qrm-swatch");
    entry.append(shape.name);
  });
  if (motion.arrows.some((arrow) => arrow.is_reaction)) arrowKey("reaction", "qrm-arrow qrm-reaction");
  if (motion.arrows.some((arrow) => !arrow.is_reaction)) arrowKey("load", "qrm-arrow qrm-load");
  forceKey = planned.most > 0 ? html(legend, "li", "qrm-scale") : null;
}

/** Tells how long the arrow of a round number of newtons is. */
function keyForces(pixelPerNewton) {
  if (!forceKey) return;
  const newton = nice(30 / pixelPerNewton);
  const length = round(newton * pixelPerNewton);
  const power = exponentFor(newton, 0.1, 1000);
  const value = newton / 10 ** power;
  forceKey.replaceChildren();
  const key = element(forceKey, "svg", { "aria-hidden": "true", width: length, height: 10 });
  element(key, "path", { d: `M.5 1.5v7M.5 5H${length - 0.5}M${length - 0.5} 1.5v7` });
  html(forceKey, "span", "", `${fixed(value, decimalsOf(value))} ${PREFIXES[power]}N`);
}

// Controls.
const slider = part("slider");
slider.addEventListener("pointerdown", () => (isHeld = true));
for (const name of ["pointerup", "pointercancel"]) addEventListener(name, () => (isHeld = false));
slider.addEventListener("input", () => {
  if (isHeld) show(Number(slider.value));
  else seek(Number(slider.value));
});
part("play").addEventListener("click", () => play(!isPlaying));
part("back").addEventListener("click", () => move(-1));
part("forth").addEventListener("click", () => move(1));

let speeds = [];
let isSpeedChosen = false;

/** The usual speeds, and one at which a very short or very long motion takes a few seconds. */
function listSpeeds() {
  const usual = [0.05, 0.1, 0.25, 0.5, 1, 2];
  const own = duration > 0 && (duration < 0.5 || duration > 60) ? Number((duration / 5).toPrecision(1)) : 1;
  const offered = [...new Set([...usual, own])].sort((a, b) => a - b);
  if (String(offered) !== String(speeds)) {
    speeds = offered;
    if (!isSpeedChosen || !offered.includes(speed)) speed = own;
    part("speed").replaceChildren();
    for (const each of speeds) {
      const option = html(part("speed"), "option", "", `${each}\u00d7`);
      option.value = each;
      option.selected = each === speed;
    }
  }
  note();
}

function note() {
  const seconds = duration / speed;
  const loop = seconds < 0.1 || seconds >= 1000 ? seconds.toPrecision(2) : seconds.toFixed(seconds < 10 ? 2 : 0);
  const times = (factor) => `${Number(factor.toPrecision(3))} times`;
  const pace = speed === 1 ? "real time" : speed < 1 ? `${times(1 / speed)} slower` : `${times(speed)} faster`;
  part("note").textContent = `${pace}, a loop takes ${Number(loop)} s`;
}
part("speed").addEventListener("change", () => {
  [speed, isSpeedChosen] = [Number(part("speed").value), true];
  note();
});
function offerSwitches() {
  const has = {
    forces: motion.arrows.length > 0,
    paths: motion.nodes.some((node) => node.is_traced),
    names: motion.nodes.some((node) => node.name),
  };
  for (const name in has) part(name).parentElement.hidden = !has[name];
}
for (const name of ["forces", "paths", "names"]) {
  const box = part(name);
  const apply = () => root.classList.toggle(`qrm-no-${name}`, !box.checked);
  box.addEventListener("change", apply);
  apply();
}

// A page hears keys wherever they are pressed, a piece of one only where it has the focus.
(isPage ? document : root).addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey) return;
  // Sliders and fields of parameters have keys of their own.
  const isOwn = (kinds) => event.target instanceof Element && event.target.matches(`${kinds}, .qrm-parameter input`);
  if (event.key === " " && !isOwn("button, select, input[type='checkbox']")) play(!isPlaying);
  else if (event.key === "ArrowLeft" && !isOwn("select")) move(-1);
  else if (event.key === "ArrowRight" && !isOwn("select")) move(1);
  else return;
  event.preventDefault();
});

// Sizes. What is drawn is in pixels, so that lines and letters stay as they are.
const sizes = new Map();
function fit(targets) {
  // All are read before anything is drawn: a size that is read after that is computed anew.
  const read = targets.map((target) => [target, target.clientWidth, target.clientHeight]);
  for (const [target, width, height] of read) {
    const [before, above] = sizes.get(target) ?? [];
    if (!(width > 40 && height > 40) || (before === width && above === height)) continue;
    sizes.set(target, [width, height]);
    redraw(target);
  }
  show(time);
}

function redraw(target) {
  const [width, height] = sizes.get(target);
  removeFrame();
  if (target !== part("canvas")) return void plots.find((each) => each.area === target)?.layout(width, height);
  drawing = draw(target.firstElementChild, motion, planned, width, height, isDraft);
  // Later, for the legend may wrap anew: an observer must not change sizes while it observes.
  requestAnimationFrame(() => keyForces(drawing.pixelPerNewton));
}
const observer = new ResizeObserver((entries) => fit(entries.map((entry) => entry.target)));
// In a long report nothing is drawn that is out of sight.
new IntersectionObserver((entries) => (isSeen = entries[entries.length - 1].isIntersecting)).observe(root);

function fromAddress() {
  const wanted = parseFloat(/[#&]t=([^&]*)/.exec(location.hash)?.[1]);
  if (Number.isFinite(wanted)) seek(wanted);
  return Number.isFinite(wanted);
}
if (isPage) addEventListener("hashchange", fromAddress);

/** Begins to play, unless the address asks for a time. */
function start() {
  if (!(isPage && fromAddress()) && !matchMedia("(prefers-reduced-motion: reduce)").matches) play(true);
}
