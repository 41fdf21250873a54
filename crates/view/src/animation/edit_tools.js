// Tools that draw a mechanism: each change goes to the server, which writes it to the scene file.

/** The tools, with a hint for each. */
const TOOLS = {
  watch: ["Watch", ""],
  move: ["Move", "Drag a joint: the lengths of its links change, all other joints stay."],
  bar: ["Bar", "Click where a bar begins, and where it ends; the next bar begins there. A bar that begins at an empty place is pinned to the ground."],
  point: ["Point", "Click on a link, or drag from it: it gets a point there, with its path."],
  pin: ["Pin", "Click on a point: it is pinned to the ground."],
  slider: ["Slider", "Click on a point: it slides along x. Drag from it for another direction."],
  drive: ["Drive", "Click on a pin of the ground: it turns once in a second. A second click removes the drive."],
  force: ["Force", "Click on a joint: its force is an output. A second click removes it."],
  path: ["Path", "Click on a point: its path is drawn. A second click removes it."],
};
/** The distance in pixels at which the pointer takes a point. */
const REACH = 15;

let tool = "watch";
/** Places of points that were drawn and are not in the motion yet, by their names. */
let drawn = {};
/** The end of the last bar, from which the next one begins. */
let chain = null;
/** Parameters that follow the file while a point is moved. */
const followed = new Set();
/** Whether the file has a change that the motion does not show yet. */
let isBehind = false;
/** The changes that were asked for, one after another. */
let asking = Promise.resolve();

const tools = html(root, "div", "qrm-tools");
tools.setAttribute("role", "group");
tools.setAttribute("aria-label", "Drawing");
const toolButtons = Object.entries(TOOLS).map(([name, [label, hint]]) => {
  const button = html(tools, "button", `qrm-tool-${name}`, label);
  button.title = hint;
  button.addEventListener("click", () => choose(name));
  return [name, button];
});
for (const [name, label, key] of [["undo", "Undo", "Ctrl+Z"], ["redo", "Redo", "Ctrl+Y"]]) {
  const button = html(tools, "button", `qrm-${name}`, label);
  button.title = key;
  button.addEventListener("click", () => step(name));
}
const hint = html(tools, "p", "qrm-hint-line");
hint.setAttribute("role", "status");
if (packed.is_writable) part("stage").prepend(tools);
else tools.remove();

const overlay = element(part("canvas"), "svg", { class: "qrm-overlay", "aria-hidden": "true" });

/** Shows a refusal, or the hint of the tool. */
function say(refusal = "") {
  hint.textContent = refusal || TOOLS[tool][1];
  hint.toggleAttribute("data-refused", refusal !== "");
}

function choose(next) {
  [tool, chain] = [next, null];
  overlay.replaceChildren();
  root.dataset.tool = tool;
  for (const [name, button] of toolButtons) button.setAttribute("aria-pressed", name === tool);
  say();
  isScaleKept = tool !== "watch";
  if (isScaleKept) fetch("tools", { method: "POST" }).catch(() => {});
  if (!motion) return;
  if (isScaleKept) seek(begin);
  else recompute();
}

/** What is new in a scene that is shown. */
function sceneShown() {
  if (!chain) overlay.replaceChildren();
  isBehind = false;
  for (const { name } of motion?.nodes ?? []) delete drawn[name];
  if (tool !== "watch" && !part("problem").hidden) say(part("problem").textContent);
  if (packed.is_writable && !("tool" in root.dataset)) choose(motion?.nodes.length === 0 ? "bar" : "watch");
}

/** Where the points are at the start, by their names. */
function places() {
  const at = { frame: 0, part: 0 };
  const named = motion.nodes.filter(({ name }) => name);
  return { ...Object.fromEntries(named.map(({ name, x, y }) => [name, [valueAt(x, at), valueAt(y, at)]])), ...drawn };
}

/** Queues a request; resolves to whether it was granted, after `done` has taken the answer. */
function ask(path, body = () => "", done = () => {}) {
  asking = asking.then(async () => {
    let answer, said;
    try {
      answer = await fetch(path, { method: "POST", body: body() });
      said = await answer.text();
    } catch (problem) {
      say(`The scene is not changed: ${problem.message}.`);
      return false;
    }
    say(answer.ok ? "" : said);
    if (answer.ok) done(said);
    return answer.ok;
  });
  return asking;
}

/** Queues a change of the scene. `edit` says what, when its turn comes; `named` takes the names of the ends of a bar. */
function change(edit, { gesture, at, named = () => {} } = {}) {
  return ask("edit", () => JSON.stringify({ edit: edit(), places: at ?? places(), gesture }), (said) => {
    const { points, values } = JSON.parse(said);
    if (!gesture || !followValues(values)) isBehind = true;
    named(points);
  });
}

function step(name) {
  [drawn, chain] = [{}, null];
  overlay.replaceChildren();
  ask(name, undefined, () => (isBehind = true));
}

addEventListener("keydown", (event) => {
  if (!packed.is_writable || (event.target instanceof Element && event.target.matches("input"))) return;
  const key = event.key.toLowerCase();
  const isControl = event.ctrlKey || event.metaKey;
  if (pressed?.move && (key === "escape" || (isControl && key === "z"))) cancelMove();
  else if (key === "escape" && tool !== "watch") choose(chain ? tool : "watch");
  else if (isControl && (key === "y" || (key === "z" && event.shiftKey))) step("redo");
  else if (isControl && key === "z") step("undo");
  else return;
  event.preventDefault();
});

/** A place in pixels in metres, on a grid of about a pixel. */
function snapped(place) {
  const grid = nice(1 / drawing.scale);
  const decimals = clamp(decimalsOf(grid), 0, 12);
  return drawing.toMetres(...place).map((value) => Number((Math.round(value / grid) * grid).toFixed(decimals)));
}

/** Where a point is in pixels. */
function pixelsOf(name, [x, y] = places()[name]) {
  const [left, top] = drawing.toMetres(0, 0);
  return [(x - left) * drawing.scale, (top - y) * drawing.scale];
}

/** The point next to a place, null where none is near. */
function pointNear([x, y]) {
  let best = { distance: REACH, name: null };
  for (const [name, place] of Object.entries(places())) {
    const [px, py] = pixelsOf(name, place);
    const distance = Math.hypot(px - x, py - y);
    if (distance < best.distance) best = { distance, name };
  }
  return best.name;
}

/** The topmost link under the pointer. */
const linkUnder = (event) => shapesUnder(event).find(({ name }) => name)?.name;

/** Marks the point under the pointer, and draws the bar that would begin at a place. */
function sketch(from, to) {
  overlay.replaceChildren();
  const near = pointNear(to);
  const end = near ? pixelsOf(near) : to;
  if (from) element(overlay, "line", { x1: from[0], y1: from[1], x2: end[0], y2: end[1] });
  if (near) element(overlay, "circle", { cx: end[0], cy: end[1], r: 10 });
}

/** Takes a place as an end of a bar. */
async function endBar(place) {
  const near = pointNear(place);
  const begun = chain;
  if (near && near === begun?.name) return choose(tool);
  const at = snapped(place);
  // The name of a new point is known when its bar is written.
  const end = { name: near, end: near ? { point: near } : { place: at }, pixels: near ? pixelsOf(near) : place };
  chain = end;
  if (!begun) return;
  const named = (names) => names.forEach((name, place) => {
    const each = [begun, end][place];
    if (each.end.place) drawn[name] = each.end.place;
    [each.name, each.end] = [name, { point: name }];
  });
  if (!(await change(() => ({ bar: { from: begun.end, to: end.end } }), { named }))) choose(tool);
}

/** What the tools do with a point. */
const AT_POINT = {
  pin: (point) => change(() => ({ pin: { point } })),
  drive: (point) => change(() => ({ drive: { point } })),
  force: (point) => change(() => ({ force: { point } })),
  path: (point) => change(() => ({ path: { point } })),
};

/** Shows the motion for new values, if all of them are parameters of the scene that is shown. */
function followValues(values) {
  const names = Object.keys(values);
  if (isBehind || !names.every((name) => about.parameters.some((each) => each.name === name))) return false;
  for (const name of names) {
    setValue(name, values[name]);
    followed.add(name);
  }
  recompute(true);
  return true;
}

/** Moves a point to where the pointer is; the next place is asked for when the last one is written. */
function mover(point) {
  const [gesture, at] = [crypto.randomUUID(), places()];
  let [wanted, isBusy, isCancelled, hasMoved] = [null, false, false, false];
  const follow = async () => {
    if (isBusy) return;
    isBusy = true;
    while (wanted) {
      const to = wanted;
      wanted = null;
      if (await change(() => ({ move: { point, to } }), { gesture, at })) hasMoved = true;
    }
    if (isCancelled && hasMoved) await ask("undo", undefined, () => (isBehind = true));
    isBusy = false;
    if (!pressed) showWaiting();
  };
  return {
    to(place) {
      wanted = snapped(place);
      follow();
    },
    cancel() {
      [wanted, isCancelled] = [null, true];
      follow();
    },
  };
}

let pressed = null;

/** Ends the move of a point, and undoes it. */
function cancelMove() {
  const move = pressed?.move;
  pressed = null;
  move?.cancel();
}

part("canvas").addEventListener("pointerdown", (event) => {
  if (tool === "watch" || event.button !== 0 || !drawing) return;
  event.stopImmediatePropagation();
  event.preventDefault();
  // What is drawn is the position at the start.
  if (isPlaying || time !== begin) return seek(begin);
  part("canvas").setPointerCapture(event.pointerId);
  const place = pixels(event);
  const point = pointNear(place);
  if (tool === "move" && isBehind) return say("The page does not show the last change yet.");
  pressed = { id: event.pointerId, place, point, link: linkUnder(event), move: tool === "move" && point ? mover(point) : null };
  if (tool === "bar") endBar(place);
  else if (tool === "point") {
    if (!pressed.link) say("There is no link here: click on one.");
  } else if (!point) say("There is no point here: click on one.");
  else AT_POINT[tool]?.(point);
}, true);

part("canvas").addEventListener("pointermove", (event) => {
  if (tool === "watch" || !drawing) return;
  const place = pixels(event);
  pressed?.move?.to(place);
  const isDrawn = (tool === "slider" && pressed?.point) || (tool === "point" && pressed?.link);
  sketch(tool === "bar" ? chain?.pixels : isDrawn ? pressed.place : null, place);
});

part("canvas").addEventListener("pointerup", (event) => {
  if (tool === "watch" || event.pointerId !== pressed?.id) return;
  const [place, { place: from, point, link, move }] = [pixels(event), pressed];
  pressed = null;
  const [dx, dy] = [place[0] - from[0], from[1] - place[1]];
  const isDrag = Math.hypot(dx, dy) > REACH;
  if (move) {
    if (place[0] !== from[0] || place[1] !== from[1]) move.to(place);
    else showWaiting();
  } else if (tool === "point" && link) change(() => ({ point: { link, to: snapped(place) } }));
  else if (tool === "bar" && isDrag) endBar(place);
  else if (tool === "slider" && point) {
    const degrees = isDrag ? 5 * Math.round((Math.atan2(dy, dx) * 36) / Math.PI) : 0;
    change(() => ({ slider: { point, direction: (degrees * Math.PI) / 180 } }));
  }
});

part("canvas").addEventListener("pointercancel", cancelMove);

part("canvas").addEventListener("wheel", (event) => {
  if (tool === "watch" || !drawing) return;
  event.preventDefault();
  const factor = 1.0015 ** event.deltaY;
  const [x, y] = drawing.toMetres(...pixels(event));
  const { left, right, bottom, top } = planned.box;
  const scaled = (from, value) => from + factor * (value - from);
  planned.box = { left: scaled(x, left), right: scaled(x, right), bottom: scaled(y, bottom), top: scaled(y, top) };
  redraw(part("canvas"));
  show(time);
  overlay.replaceChildren();
}, { passive: false });
