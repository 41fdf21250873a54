// Pictures of the page as files.

/** What the style sheet of the page says of a picture. */
const STYLES = [
  "display", "visibility", "opacity", "fill", "fill-opacity", "fill-rule", "stroke", "stroke-width", "stroke-linecap", "stroke-linejoin",
  "stroke-dasharray", "stroke-dashoffset", "paint-order", "font-family", "font-size", "font-weight", "font-variant-numeric",
];

/** A copy of a picture that needs no style sheet. */
function standalone(svg) {
  const copy = svg.cloneNode(true);
  const [from, to] = [svg, copy].map((each) => [each, ...each.querySelectorAll("*")]);
  from.forEach((original, place) => {
    const style = getComputedStyle(original);
    to[place].removeAttribute("class");
    for (const name of STYLES) to[place].style.setProperty(name, style.getPropertyValue(name));
  });
  return copy;
}

/** Saves pictures below each other, each with a line of words in their colours above it. */
function save(name, pictures) {
  const width = Math.max(...pictures.map(({ svg }) => svg.viewBox.baseVal.width));
  const whole = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  let top = 0;
  for (const { svg, words } of pictures) {
    const { width: own, height } = svg.viewBox.baseVal;
    const line = element(whole, "text", { x: 12, y: top + 18, "font-family": "sans-serif", "font-size": 12.5 });
    for (const { text, fill } of words) element(line, "tspan", { fill, dx: 6 }, text);
    const copy = standalone(svg);
    for (const [key, value] of Object.entries({ x: 0, y: top + 26, width: own, height })) copy.setAttribute(key, value);
    copy.style.position = "static";
    whole.append(copy);
    top += height + 34;
  }
  const back = getComputedStyle(part("stage")).backgroundColor;
  whole.prepend(element(whole, "rect", { width, height: top, fill: back }));
  for (const [key, value] of Object.entries({ viewBox: `0 0 ${width} ${top}`, width, height: top })) whole.setAttribute(key, value);
  download(`${name}.svg`, new XMLSerializer().serializeToString(whole), "image/svg+xml");
}

/** Gives a file to the reader of the page. */
function download(name, content, type) {
  const link = html(root, "a");
  link.download = name;
  link.href = URL.createObjectURL(new Blob([content], { type }));
  link.click();
  link.remove();
  setTimeout(() => URL.revokeObjectURL(link.href), 10000);
}

const caption = (node) => ({ text: node.textContent, fill: getComputedStyle(node).color });
part("save-drawing").addEventListener("click", () => {
  const words = [caption(part("title")), caption(part("time"))];
  save(`${about.name}-drawing`, [{ svg: part("canvas").firstElementChild, words }]);
});
part("save-curves").addEventListener("click", () => {
  const words = (figure) => {
    const keys = [...figure.querySelectorAll(".qrm-key")].map((key) => ({
      text: key.querySelector(".qrm-whose").textContent,
      fill: getComputedStyle(key.querySelector(".qrm-swatch")).backgroundColor,
    }));
    return [...[...figure.querySelectorAll("figcaption span")].map(caption), ...(keys.length > 1 ? keys : [])];
  };
  const figures = [...root.querySelectorAll(".qrm-plot")];
  save(`${about.name}-curves`, figures.map((figure) => ({ svg: figure.querySelector(".qrm-area svg"), words: words(figure) })));
});
part("save-table").addEventListener("click", () => {
  removeFrame();
  const curves = motion.plots.flatMap(({ unit, curves }) => curves.map(({ name, values }) => [`${name}${unit && ` [${unit}]`}`, values]));
  const axis = chosenAxis();
  if (axis !== axes[0]) curves.unshift([`${axis.name} [${axis.unit}]`, times.map((time, frame) => axis.at({ frame, part: 0 }, time))]);
  const row = (time, frame) => [time, ...curves.map(([, values]) => values[values.length === 1 ? 0 : frame])].map((value) => (Number.isFinite(value) ? value : ""));
  const lines = [["t [s]", ...curves.map(([name]) => name)], ...times.map(row)];
  download(`${about.name}-curves.csv`, `${lines.join("\n")}\n`, "text/csv");
  show(time);
});
