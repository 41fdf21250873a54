// Curves over time or over the angle of a link, each plot with a cursor at the time shown.

/** Units that take a prefix. */
const PREFIXED = ["N", "N m", "W", "J", "Pa"];
const SUPERSCRIPTS = [..."\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079"];

/** Builds a plot for data of one kind into a holder; `seek` is called with the time that is pointed at. */
function plot(holder, { title, curves: names }, seek) {
  const figure = html(holder, "figure", "qrm-plot");
  const caption = html(figure, "figcaption", "qrm-caption");
  html(caption, "span", "qrm-what", title);
  const unit = html(caption, "span", "qrm-unit");
  const legend = html(figure, "div", "qrm-keys");
  const area = html(figure, "div", "qrm-area");
  const svg = element(area, "svg", { role: "img", "aria-label": `${title} over time` });
  const curves = names.map(({ name }, place) => {
    const key = html(legend, "span", `qrm-key qrm-c${place % 8}`);
    html(key, "i", "qrm-swatch");
    html(key, "span", "qrm-whose", name);
    const value = html(key, "output", "qrm-value");
    value.setAttribute("aria-live", "off");
    return { values: [], value, style: `qrm-c${place % 8}` };
  });

  let [times, axis] = [[], null];
  let [low, high, exponent, decimals] = [0, 1, 0, 0];
  const number = (value) => (Number.isFinite(value) ? fixed(value / 10 ** exponent, decimals) : "\u2013");

  /** Takes the data and what they are drawn over; they are drawn with the next layout. */
  function setData(data, nextTimes, nextAxis) {
    [times, axis] = [nextTimes, nextAxis];
    [low, high] = rangeOf(data.curves.map((curve) => curve.values));
    const largest = Math.max(Math.abs(low), Math.abs(high));
    exponent = data.unit === "N" ? exponentFor(largest, 0.1, 1000) : exponentFor(largest, 0.01, 10000);
    // What differs in the last digit only is constant: rounding is not shown as a curve.
    if (high - low <= 2e-5 * largest || high === low) {
      const room = 0.2 * largest || 1;
      [low, high] = [low - room, high + room];
    } else {
      // Zero is worth seeing if it is near.
      if (low > 0 && low < 0.35 * (high - low)) low = 0;
      if (high < 0 && -high < 0.35 * (high - low)) high = 0;
      const room = 0.06 * (high - low);
      [low, high] = [low - (low === 0 ? 0 : room), high + (high === 0 ? 0 : room)];
    }
    decimals = clamp(decimalsOf(nice((high - low) / 3 / 10 ** exponent)) + 2, 0, 9);
    // As in the drawing.
    const hasPrefix = PREFIXED.includes(data.unit);
    const power = exponent && !hasPrefix ? `10${[...String(exponent)].map((sign) => SUPERSCRIPTS[sign] ?? "\u207b").join("")}` : "";
    const text = hasPrefix ? PREFIXES[exponent] + data.unit : [power, data.unit].filter((part) => part).join(" ");
    unit.textContent = text && ` in ${text}`;
    // Room for the longest number, so that nothing beside it moves.
    const width = `${Math.max(number(low).length, number(high).length)}ch`;
    curves.forEach((curve, place) => {
      curve.values = data.curves[place].values;
      curve.value.style.minWidth = width;
    });
  }

  let [toX, toY, cursor] = [() => 0, () => 0, null];
  function layout(width, height) {
    svg.replaceChildren();
    svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
    const edge = { left: 50, right: width - 12, top: 6, bottom: height - 18 };
    const [from, to] = axis.range();
    toX = (value) => edge.left + ((value - from) / (to - from || 1)) * (edge.right - edge.left);
    toY = (value) => edge.bottom - ((value - low) / (high - low)) * (edge.bottom - edge.top);

    const grid = element(svg, "g", { class: "qrm-grid" });
    const rise = nice((high - low) / clamp((edge.bottom - edge.top) / 15, 2, 8));
    const lines = { thin: "", zero: "" };
    for (const value of multiples(low, high, rise)) {
      const y = round(toY(value));
      lines[Math.abs(value) < rise / 2 ? "zero" : "thin"] += `M${edge.left} ${y}H${edge.right}`;
      const text = fixed(value / 10 ** exponent, decimalsOf(rise / 10 ** exponent));
      element(grid, "text", { x: edge.left - 6, y: y + 3.5, "text-anchor": "end" }, text);
    }
    const run = axis.step(to - from || 1, clamp((edge.right - edge.left) / 46, 2, 8));
    const ticks = multiples(from, to, run);
    ticks.forEach((tick, place) => {
      const x = round(toX(tick));
      lines.thin += `M${x} ${edge.top}V${edge.bottom}`;
      const text = fixed(tick / 10 ** axis.exponent, decimalsOf(run / 10 ** axis.exponent));
      const isLast = place === ticks.length - 1;
      // The unit hangs on the last number, which is kept inside.
      const shown = isLast ? `${text} ${axis.unit}` : text;
      const isNear = x > edge.right - 18;
      const [at, anchor] = isNear ? [edge.right + 8, "end"] : [x, "middle"];
      element(grid, "text", { x: at, y: height - 4, "text-anchor": anchor }, shown);
    });
    element(grid, "path", { d: lines.thin });
    element(grid, "path", { d: lines.zero, class: "qrm-zero" });

    const places = times.map((time, frame) => axis.at({ frame, part: 0 }, time));
    for (const curve of curves) {
      let path = "";
      let pen = "M";
      curve.values.forEach((value, frame) => {
        // An angle begins its turn anew.
        if (frame > 0 && Math.abs(places[frame] - places[frame - 1]) > axis.jump) pen = "M";
        if (!Number.isFinite(value)) return void (pen = "M");
        path += `${pen}${round(toX(places[frame]))} ${round(toY(value))}`;
        pen = "L";
      });
      // A curve of one value is one for all times.
      if (curve.values.length === 1 && path) path = `M${edge.left} ${round(toY(curve.values[0]))}H${edge.right}`;
      element(svg, "path", { class: `qrm-curve ${curve.style}`, d: path });
    }
    cursor = element(svg, "path", { class: "qrm-cursor", d: `M0 ${edge.top}V${edge.bottom}` });
    for (const curve of curves) curve.dot = element(svg, "circle", { class: `qrm-spot ${curve.style}`, r: 3.5 });
    svg.onpointerdown = (event) => {
      if (event.button !== 0) return;
      svg.setPointerCapture(event.pointerId);
      point(event);
    };
    svg.onpointermove = (event) => svg.hasPointerCapture(event.pointerId) && point(event);
    function point(event) {
      const bounds = svg.getBoundingClientRect();
      const x = ((event.clientX - bounds.left) / bounds.width) * width;
      seek(axis.timeAt(from + clamp((x - edge.left) / (edge.right - edge.left), 0, 1) * (to - from)));
    }
  }

  function update(time) {
    if (!cursor) return;
    const at = locate(times, time);
    const x = round(toX(axis.at(at, time)));
    cursor.setAttribute("transform", `translate(${x} 0)`);
    for (const { values, value, dot } of curves) {
      const now = valueAt(values, at);
      value.textContent = number(now);
      dot.setAttribute("visibility", Number.isFinite(now) ? "visible" : "hidden");
      if (Number.isFinite(now)) dot.setAttribute("transform", `translate(${x} ${round(toY(now))})`);
    }
  }
  return { area, setData, layout, update };
}
