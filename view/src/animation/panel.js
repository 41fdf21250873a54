// A scene that is simulated here: a slider for each parameter, a run for each change.

const packed = JSON.parse(root.querySelector("script[type='application/json']").textContent);
let module = null;
let about = null;
/** The values of parameters and of coordinates at the start that were changed, by their names. */
let changed = {};
let engine = null;
let sceneShown = "";
let isDue = false;

/** Shows a text in a part of the page, which is hidden without one. */
function setText(name, text) {
  part(name).textContent = text;
  part(name).hidden = text === "";
}

/** As many digits as a slider can set. */
const short = (value) => Number(value.toPrecision(5));

const settable = (of) => [...of.parameters, ...of.start];
const ownValue = (of, name) => settable(of).find((each) => each.name === name)?.value;

/** Shows a scene. */
async function loadOrReport(scene) {
  try {
    await load(scene);
  } catch (problem) {
    setText("problem", `the motion cannot be computed here: ${problem.message}`);
  }
}

/** Loads a scene. Values that were changed stay, unless the scene has a new value of its own for them. */
async function load(scene) {
  module ??= await WebAssembly.compile(await unpacked(packed.module));
  const next = await simulator(module);
  const before = about;
  sceneShown = scene;
  values = {};
  about = next.load(await unpacked(scene));
  engine = next;
  part("title").textContent = document.title = about.name;
  part("doc").textContent = about.doc;
  if (before) {
    const isKept = ([name]) => ownValue(about, name) !== undefined && ownValue(about, name) === ownValue(before, name);
    changed = Object.fromEntries(Object.entries(changed).filter(isKept));
  } else {
    changed = addressed();
  }
  recompute(motion !== null);
  listParameters();
  if (!motion || "ready" in root.dataset) return;
  root.dataset.ready = "";
  start();
}

/** When values have not changed for so many milliseconds, the error is estimated too. */
const SETTLED = 150;
let settling = 0;

/** The motion for the values as they are; what cannot be shown leaves the last motion. */
function recompute(draft = false) {
  isDue = false;
  clearTimeout(settling);
  root.toggleAttribute("data-draft", draft);
  if (draft) settling = setTimeout(recompute, SETTLED);
  const begun = performance.now();
  try {
    if (!engine) return void loadOrReport(sceneShown);
    const { run, motion } = engine.run(changed, draft ? end : NaN);
    install(motion, draft, isDragged ? planned : null);
    report(run, performance.now() - begun);
    setText("problem", run.broken_off ?? "");
  } catch (problem) {
    setText("problem", problem.message);
    // An instance that broke down is of no more use.
    if (problem instanceof WebAssembly.RuntimeError) engine = null;
  }
  const isParameter = (name) => about.parameters.some((each) => each.name === name);
  const option = ([name, value]) => ` --${isParameter(name) ? "set" : "start"} ${name}=${value}`;
  const options = Object.entries(changed).map(option);
  part("command").firstElementChild.textContent = `qrm run ${packed.command}${options.join("")}`;
  part("reset").disabled = part("write").disabled = options.length === 0;
}

/** What is known of a run; also as data, to the last digit. */
function report(run, milliseconds) {
  const error = run.estimated_error === null ? ", error not estimated yet" : `, error about ${run.estimated_error.toExponential(0)}`;
  const doubts = run.distrust.length ? ` Do not trust these numbers: ${run.distrust.join("; ")}.` : "";
  for (const [name, show] of rows) {
    if (!(name in changed) && run.values[name] !== values[name]) show(run.values[name]);
  }
  values = run.values;
  part("run").textContent = `${run.steps} steps in ${milliseconds.toFixed(0)} ms${error}.${doubts}`;
  root.dataset.run = JSON.stringify(run);
}

/** Once for each picture, however often a slider moves in between. */
function recomputeSoon() {
  if (isDue) return;
  isDue = true;
  root.toggleAttribute("data-draft", true);
  requestAnimationFrame(() => recompute(true));
}

function changeOf(name, value) {
  if (value === ownValue(about, name)) delete changed[name];
  else changed[name] = value;
  recomputeSoon();
}

/** The values that the address asks for: `#O2A=0.25&J2=90`. */
function addressed() {
  const asked = new URLSearchParams(location.hash.slice(1));
  const known = settable(about).filter(({ name }) => asked.has(name) && Number.isFinite(Number(asked.get(name))));
  return Object.fromEntries(known.map(({ name }) => [name, Number(asked.get(name))]));
}

/** The values of the last run: some follow from others. */
let values = {};
/** What shows the value of a parameter or of a coordinate at the start, by its name. */
const rows = new Map();

function listParameters() {
  part("parameters").replaceChildren();
  rows.clear();
  about.parameters.forEach((each) => listParameter(each));
  if (about.start.length > 0) html(part("parameters"), "h3", "qrm-start", "At the start");
  about.start.forEach((each) => listParameter(each, each.unit === "rad" ? Math.PI : 0));
}

/** The row of a parameter, whose slider goes so far to both sides of its value. */
function listParameter({ name, unit, doc, value }, reach = 0) {
  const row = html(part("parameters"), "label", "qrm-parameter");
  row.title = doc;
  html(row, "span", "qrm-whose", name);
  const range = html(row, "input");
  [range.type, range.step] = ["range", "any"];
  const far = reach || Math.abs(0.5 * value) || 1;
  [range.min, range.max] = [value - far, value + far];
  const number = html(row, "input");
  [number.type, number.step, number.name] = ["number", "any", name];
  number.setAttribute("aria-label", `${name}${unit ? ` in ${unit}` : ""}`);
  const set = (shown) => (number.value = range.value = shown);
  set(changed[name] ?? values[name] ?? value);
  rows.set(name, set);
  html(row, "span", "qrm-unit", unit.replaceAll("^2", "\u00b2").replaceAll("^3", "\u00b3"));
  range.addEventListener("input", () => {
    number.value = short(Number(range.value));
    changeOf(name, Number(number.value));
  });
  number.addEventListener("change", () => {
    const typed = number.value === "" || !Number.isFinite(Number(number.value)) ? value : Number(number.value);
    set(typed);
    changeOf(name, typed);
  });
}

part("reset").addEventListener("click", () => {
  changed = {};
  listParameters();
  recompute();
});
