// Outlines of gears, racks, belts, springs and cylinders, as paths in pixels.

const pathOf = (places) => places.map(([x, y], place) => `${place ? "L" : "M"}${round(x)} ${round(y)}`).join("");
/** Angles are counter-clockwise, and pixels go down. */
const polar = (radius, angle) => [radius * Math.cos(angle), -radius * Math.sin(angle)];

/** How far teeth reach beyond the pitch circle and below it, and the rim of a ring, in modules. */
const TEETH = { tip: 0.8, root: 1, rim: 2.6 };
/** The corners of a tooth: whether they are at its tip, and where they are beside its middle in pitches. */
const CORNERS = [[false, -0.32], [true, -0.13], [true, 0.13], [false, 0.32]];

/** How far a gear reaches, in the unit of its radius. */
const gearReach = ({ radius, teeth, is_internal }) => radius + (is_internal ? TEETH.rim : TEETH.tip) * (2 * radius) / teeth;

/** The outline of a gear, of a ring with its rim. */
function gearPath({ radius, teeth, phase, is_internal }, scale) {
  const module = (2 * radius) / teeth;
  const sign = is_internal ? -1 : 1;
  const places = [];
  for (let tooth = 0; tooth < teeth; tooth++) {
    for (const [isTip, aside] of CORNERS) {
      const height = sign * module * (isTip ? TEETH.tip : -TEETH.root);
      places.push(polar(scale * (radius + height), phase + ((tooth + aside) * 2 * Math.PI) / teeth));
    }
  }
  const rim = round(scale * (radius + TEETH.rim * module));
  const circle = is_internal ? `M${rim} 0A${rim} ${rim} 0 1 0 ${-rim} 0A${rim} ${rim} 0 1 0 ${rim} 0Z` : "";
  return pathOf(places) + "Z" + circle;
}

/** The outline of a rack. */
function rackPath({ along: [from, to], across, pitch, phase }, scale) {
  const [size, sign] = [Math.abs(pitch), Math.sign(pitch)];
  const height = (modules) => -scale * (across + (sign * modules * size) / Math.PI);
  const places = [];
  const first = Math.ceil((from - phase) / size);
  // Of very fine teeth not all are drawn.
  const count = size > 0 ? Math.min(Math.floor((to - phase) / size) - first + 1, 1000) : 0;
  for (let tooth = 0; tooth < count; tooth++) {
    for (const [isTip, aside] of CORNERS) {
      const x = clamp(phase + (first + tooth + aside) * size, from, to);
      places.push([scale * x, height(isTip ? TEETH.tip : -TEETH.root)]);
    }
  }
  const [root, back] = [height(-TEETH.root), height(-TEETH.rim)];
  places.push([scale * to, root], [scale * to, back], [scale * from, back], [scale * from, root]);
  return pathOf(places) + "Z";
}

/** The path of a belt, as it moves where the first pulley turns counter-clockwise; none where one lies in the other. */
function beltPath([ax, ay], [bx, by], [r, s], isCrossed) {
  const line = Math.atan2(ay - by, bx - ax);
  const opening = Math.acos((isCrossed ? r + s : r - s) / Math.hypot(bx - ax, by - ay));
  if (!Number.isFinite(opening)) return "";
  const at = (x, y, radius, angle) => {
    const [dx, dy] = polar(radius, angle);
    return [x + dx, y + dy];
  };
  const arc = (x, y, radius, [end, isLarge, isLeft]) => {
    return `A${round(radius)} ${round(radius)} 0 ${Number(isLarge)} ${Number(!isLeft)} ${at(x, y, radius, end).map(round).join(" ")}`;
  };
  const isLarge = opening < Math.PI / 2;
  const begin = at(ax, ay, r, line + opening);
  const far = at(bx, by, s, isCrossed ? line + Math.PI - opening : line - opening);
  const around = isCrossed ? [line + Math.PI + opening, isLarge, false] : [line + opening, !isLarge, true];
  return `${pathOf([begin])}${arc(ax, ay, r, [line - opening, isLarge, true])}L${far.map(round).join(" ")}${arc(bx, by, s, around)}Z`;
}

/** Where a cylinder begins and ends, and where its piston is; a stroke that fits is shown as it is. */
function cylinder(from, to, length, [low, high], half) {
  const stroke = high - low;
  const least = Math.max(low, 0.3 * high);
  const body = Math.min(clamp(stroke + 2 * half, 0.42 * least, 0.6 * least), 0.7 * (to - from));
  const start = from + 0.12 * Math.min(to - from, least);
  const moved = stroke > 0 ? (length - (low + high) / 2) * Math.min((0.7 * body) / stroke, 1) : 0;
  return [start, start + body, start + body / 2 + moved];
}

/**
 * Springs, dampers and actuators side by side, along the x axis: their lines, the areas that lie below them, and what is
 * filled. Their length moves in a range.
 */
function forceElementPaths(parts, length, range, unit) {
  const [half, lane] = [0.95 * unit, 2.8 * unit];
  const lead = Math.min(1.3 * unit, 0.14 * length);
  const [from, to] = [lead, length - lead];
  const outermost = (lane * (parts.length - 1)) / 2;
  const paths = { lines: pathOf([[0, 0], [from, 0]]) + pathOf([[to, 0], [length, 0]]), areas: "", solids: "" };
  if (outermost > 0) for (const end of [from, to]) paths.lines += pathOf([[end, -outermost], [end, outermost]]);
  parts.forEach((part, place) => {
    const y = lane * place - outermost;
    if (part === "spring") {
      const straight = 0.06 * (to - from);
      // As many turns as look well at the mean length.
      const count = 2 * clamp(Math.round((range[0] + range[1]) / (4.6 * half)), 4, 16);
      const step = (to - from - 2 * straight) / count;
      const peak = (_, turn) => [from + straight + step * (turn + 0.5), y + (turn % 2 ? half : -half)];
      const peaks = Array.from({ length: count }, peak);
      paths.lines += pathOf([[from, y], [from + straight, y], ...peaks, [to - straight, y], [to, y]]);
      return;
    }
    const [start, end, piston] = cylinder(from, to, length, range, half);
    const tube = pathOf([[end, y - half], [start, y - half], [start, y + half], [end, y + half]]);
    paths.areas += tube + "Z";
    paths.lines += pathOf([[from, y], [start, y]]);
    const [thick, high] = part === "damper" ? [0.16 * unit, 0.74 * half] : [0.34 * unit, 0.9 * half];
    const bar = (left, right, tall) => pathOf([[left, y - tall], [right, y - tall], [right, y + tall], [left, y + tall]]) + "Z";
    paths.solids += bar(piston - thick, piston + thick, high);
    if (part === "damper") paths.lines += tube + pathOf([[piston, y], [to, y]]);
    else {
      paths.lines += tube + "Z";
      const rod = bar(piston + thick, to, 0.3 * unit);
      paths.areas += rod;
      paths.lines += rod;
    }
  });
  return paths;
}
