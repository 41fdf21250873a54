// A scene that is simulated here: a slider for each parameter, a run for each change.

const packed = JSON.parse(root.querySelector("script[type='application/json']").textContent);
let about = null;
/** The values of parameters that were changed, by their names. */
let changed = {};
let engine = null;
let isDue = false;

/** As many digits as a slider can set. */
const short = (value) => Number(value.toPrecision(5));

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
    const { run, motion } = engine.run(changed, draft);
    install(motion, draft);
    report(run, performance.now() - begun);
    part("problem").hidden = true;
  } catch (problem) {
    part("problem").textContent = problem.message;
    part("problem").hidden = false;
  }
  const options = Object.entries(changed).map(([name, value]) => ` --set ${name}=${value}`);
  part("command").firstElementChild.textContent = `qrm run ${about.name}${options.join("")}`;
  part("reset").disabled = options.length === 0;
}

/** What is known of a run; also as data, to the last digit. */
function report(run, milliseconds) {
  const error = run.estimated_error === null ? ", error not estimated yet" : `, error about ${run.estimated_error.toExponential(0)}`;
  const doubts = run.distrust.length ? ` Do not trust these numbers: ${run.distrust.join("; ")}.` : "";
  part("run").textContent = `${run.steps} steps in ${milliseconds.toFixed(0)} ms${error}.${doubts}`;
  root.dataset.run = JSON.stringify(run);
}

/** Once for each picture, however often a slider moves in between. */
function changeOf(name, value) {
  const own = about.parameters.find((each) => each.name === name);
  if (value === own.value) delete changed[name];
  else changed[name] = value;
  if (isDue) return;
  isDue = true;
  root.toggleAttribute("data-draft", true);
  requestAnimationFrame(() => recompute(true));
}

/** The values that the address asks for: `#O2A=0.25&J2=90`. */
function addressed() {
  const asked = new URLSearchParams(location.hash.slice(1));
  const known = about.parameters.filter(({ name }) => asked.has(name) && Number.isFinite(Number(asked.get(name))));
  return Object.fromEntries(known.map(({ name }) => [name, Number(asked.get(name))]));
}

function listParameters() {
  part("parameters").replaceChildren();
  for (const { name, unit, doc, value } of about.parameters) {
    const row = html(part("parameters"), "label", "qrm-parameter");
    row.title = doc;
    html(row, "span", "qrm-whose", name);
    const range = html(row, "input");
    [range.type, range.step] = ["range", "any"];
    const [low, high] = value === 0 ? [-1, 1] : [0.5 * value, 1.5 * value];
    [range.min, range.max] = [Math.min(low, high), Math.max(low, high)];
    const number = html(row, "input");
    [number.type, number.step] = ["number", "any"];
    number.value = range.value = changed[name] ?? value;
    number.setAttribute("aria-label", `${name}${unit ? ` in ${unit}` : ""}`);
    html(row, "span", "qrm-unit", unit.replaceAll("^2", "\u00b2").replaceAll("^3", "\u00b3"));
    range.addEventListener("input", () => {
      number.value = short(Number(range.value));
      changeOf(name, Number(number.value));
    });
    number.addEventListener("change", () => {
      const typed = number.value === "" || !Number.isFinite(Number(number.value)) ? value : Number(number.value);
      [number.value, range.value] = [typed, typed];
      changeOf(name, typed);
    });
  }
}

part("reset").addEventListener("click", () => {
  changed = {};
  listParameters();
  recompute();
});

(async () => {
  try {
    engine = await simulator(await unpacked(packed.module));
    about = engine.load(await unpacked(packed.scene));
    changed = addressed();
    listParameters();
    recompute();
    root.dataset.ready = "";
    start();
  } catch (problem) {
    part("problem").textContent = `the motion cannot be computed here: ${problem.message}`;
    part("problem").hidden = false;
  }
})();
