// A scene that is simulated here: a slider for each parameter, a run for each change.

const { packed, unpacked } = root;
let module = null;
/** The scene that is shown, as the simulator describes it, with its instance of the simulator. */
let about = null;
let simulated = null;
/** The values of parameters and of coordinates at the start that were changed, by their names. */
let changed = {};
/** Those that were last written to the file. */
let written = {};
/** The time at which motions end, for drafts. */
let expectedEnd = Infinity;
let isDue = false;
/** Whether the scale of the drawing stays when the motion changes. */
let isScaleKept = false;

/** Shows a text in a part of the page, which is hidden without one. */
function setText(name, text) {
  part(name).textContent = text;
  part(name).hidden = text === "";
}

/** As many digits as a slider can set. */
const short = (value) => Number(value.toPrecision(5));

/** Whether a parameter is of the scene: while it is edited, `length_parameters.rs` makes lengths parameters too. */
const isListed = ({ name }) => !name.startsWith("qrm_");
const settable = (of) => [...of.parameters, ...of.start];
const ownValue = (of, name) => settable(of).find((each) => each.name === name)?.value;

let loads = 0;
/** The scene that was to be loaded last. */
let wanted = "";

/** Loads a scene and shows it, unless another one is loaded meanwhile. */
async function load(scene) {
  const number = ++loads;
  wanted = scene;
  try {
    module ??= await WebAssembly.compile(await unpacked(packed.module));
    const next = await simulator(module);
    const bytes = await unpacked(scene);
    if (number === loads) showScene(next.load(bytes), next);
  } catch (problem) {
    if (number === loads) setText("problem", `the motion cannot be computed here: ${problem.message}`);
  }
}

/** Shows a scene that was loaded. */
function showScene(loaded, instance) {
  endDrag();
  const before = about;
  [about, simulated] = [loaded, instance];
  numbersAt = exactNumbers;
  changed = before ? keptChanges(before) : addressed();
  values = {};
  expectedEnd = Math.min(expectedEnd, about.end_time);
  part("title").textContent = document.title = about.name;
  part("doc").textContent = about.doc;
  recompute(motion !== null);
  listParameters();
  if (!motion || "ready" in root.dataset) return;
  root.dataset.ready = "";
  part("save-drawing").disabled = false;
  start();
}

/** The numbers of the motion at a time; a failure is shown, and the frames tell what there was. */
function exactNumbers(time) {
  try {
    return simulated.at(time);
  } catch (problem) {
    setText("problem", problem.message);
    return null;
  }
}

/** The changes that stay: the scene has the value of before, or the one that was written before the next change. */
function keptChanges(before) {
  const isKept = ([name, value]) => {
    const own = ownValue(about, name);
    return own !== undefined && value !== own && (own === ownValue(before, name) || own === written[name]);
  };
  return Object.fromEntries(Object.entries(changed).filter(isKept));
}

/** When values have not changed for so many milliseconds, the error is estimated too. */
const SETTLE_DELAY = 150;
let settling = 0;

/** Computes the motion for the values as they are; one that fails leaves the last motion. */
function recompute(isDraft = false) {
  isDue = false;
  clearTimeout(settling);
  if (simulated.isBroken()) return void load(wanted);
  root.toggleAttribute("data-draft", isDraft);
  const begun = performance.now();
  try {
    const { run, motion } = isDraft ? simulated.draft(changed, expectedEnd) : simulated.run(changed);
    install(motion, isDraft, isDragged || isScaleKept ? planned : null);
    report(run, performance.now() - begun);
    setText("problem", run.failure ?? "");
    part("save-curves").hidden = part("save-table").hidden = motion.plots.length === 0;
    if (!isDraft && !run.failure) expectedEnd = run.end_time;
  } catch (problem) {
    setText("problem", problem.message);
  }
  // A simulator that stopped would stop again: it waits for the next change.
  if (isDraft && !simulated.isBroken()) settling = setTimeout(recompute, SETTLE_DELAY);
  else root.toggleAttribute("data-draft", false);
  const isParameter = (name) => about.parameters.some((each) => each.name === name);
  const option = ([name, value]) => ` --${isParameter(name) ? "set" : "start"} ${name}=${value}`;
  const options = Object.entries(changed).filter(([name]) => isListed({ name })).map(option);
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

function setValue(name, value) {
  const { value: own, follows } = settable(about).find((each) => each.name === name);
  if (value === own && !follows) delete changed[name];
  else changed[name] = value;
}

const asked = () => [...new URLSearchParams(location.hash.slice(1))];
const isUsed = ([name, text]) => ownValue(about, name) !== undefined && text.trim() !== "" && Number.isFinite(Number(text));
/** The values that the address asks for: `#O2A=0.25&J2=90`. */
const addressed = () => Object.fromEntries(asked().filter(isUsed).map(([name, text]) => [name, Number(text)]));
/** What else is in the address. */
const ignored = () => asked().filter((pair) => pair[0] !== "t" && !isUsed(pair)).map((pair) => pair.join("="));

addEventListener("hashchange", () => {
  const next = addressed();
  if (JSON.stringify(next) === JSON.stringify(changed) && ignored().length === 0) return;
  changed = next;
  listParameters();
  recompute();
});

/** The values of the last run: some follow from others. */
let values = {};
/** What shows the value of a parameter or of a coordinate at the start, by its name. */
const rows = new Map();

function listParameters() {
  part("parameters").replaceChildren();
  rows.clear();
  about.parameters.filter(isListed).forEach((each) => listParameter(each));
  if (about.start.length > 0) html(part("parameters"), "h3", "qrm-start", "At the start");
  about.start.forEach((each) => listParameter(each, each.unit === "rad" ? Math.PI : 0));
  const note = (names, text) => names.length > 0 && html(part("parameters"), "p", "qrm-note", `${names.join(", ")}: ${text}`);
  note(about.left_out, "zero in the scene and left out; runtime = true gives a slider");
  note(ignored(), "in the address, but no number of this scene");
}

/** The row of a parameter, whose slider goes so far to both sides of its value. */
function listParameter({ name, unit, doc, value }, reach = 0) {
  const row = html(part("parameters"), "label", "qrm-parameter");
  html(row, "span", "qrm-whose", name);
  const number = html(row, "input");
  [number.type, number.step, number.name] = ["number", "any", name];
  number.setAttribute("aria-label", `${name}${unit ? ` in ${unit}` : ""}`);
  html(row, "span", "qrm-unit", unit.replaceAll("^2", "\u00b2").replaceAll("^3", "\u00b3"));
  const range = html(row, "input");
  [range.type, range.step] = ["range", "any"];
  const far = reach || Math.abs(0.5 * value) || 1;
  [range.min, range.max] = [value - far, value + far];
  if (doc) html(row, "span", "qrm-what", doc);
  const set = (shown) => (number.value = range.value = shown);
  set(changed[name] ?? values[name] ?? value);
  rows.set(name, set);
  range.addEventListener("input", () => {
    number.value = short(Number(range.value));
    setValue(name, Number(number.value));
    recomputeSoon();
  });
  number.addEventListener("change", () => {
    const isReset = number.value === "" || !Number.isFinite(Number(number.value));
    const typed = isReset ? value : Number(number.value);
    set(typed);
    if (isReset) delete changed[name];
    else setValue(name, typed);
    // What follows from other values is shown anew.
    delete values[name];
    recomputeSoon();
  });
}

part("reset").addEventListener("click", () => {
  changed = {};
  listParameters();
  recompute();
});
