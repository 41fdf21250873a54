// The drawing.

/** The distance that a shape reaches around each of its nodes. */
function radiiOf(shape) {
  if (shape.kind === "gear") return [gearReach(shape)];
  if (shape.kind === "outline") return [Math.max(...shape.x.map((x, corner) => Math.hypot(x, shape.y[corner])))];
  return shape.radii ?? [];
}

/** The abscissae and ordinates that shapes reach beyond their nodes. */
function reachOf({ nodes, shapes, times }) {
  const reach = { x: [], y: [] };
  for (const shape of shapes) {
    const ids = shape.nodes ?? [shape.node];
    radiiOf(shape).forEach((radius, turn) => {
      for (const axis of ["x", "y"]) {
        const [low, high] = rangeOf([nodes[ids[turn]][axis]]);
        reach[axis].push(low - radius, high + radius);
      }
    });
    if (!shape.along) continue;
    times.forEach((_, frame) => {
      const at = { frame, part: 0 };
      const angle = angleAt(shape.angle, at);
      const [cos, sin, across] = [Math.cos(angle), Math.sin(angle), shape.across ?? 0];
      for (const along of shape.along) {
        reach.x.push(valueAt(nodes[shape.node].x, at) + along * cos - across * sin);
        reach.y.push(valueAt(nodes[shape.node].y, at) + along * sin + across * cos);
      }
    });
  }
  return reach;
}

/** What does not depend on the size of the drawing: what is reached, the scale of the forces, the colours. */
function plan(motion) {
  const reach = reachOf(motion);
  const [left, right] = rangeOf([...motion.nodes.map((node) => node.x), reach.x]);
  const [bottom, top] = rangeOf([...motion.nodes.map((node) => node.y), reach.y]);
  const far = Math.max(Math.abs(left), Math.abs(right), Math.abs(bottom), Math.abs(top));
  const extent = Math.max(right - left, top - bottom);
  // Where nothing ever moves apart, any size will do.
  const size = extent > 1e-6 * far ? extent : far || 1;

  const count = (arrow) => Math.max(arrow.x.length, arrow.y.length);
  const pick = (track, frame) => track[Math.min(frame, track.length - 1)];
  const largest = motion.arrows.map((arrow) => {
    let most = 0;
    for (let frame = 0; frame < count(arrow); frame++) {
      most = Math.max(most, Math.hypot(pick(arrow.x, frame), pick(arrow.y, frame)));
    }
    return most;
  });
  const most = Math.max(0, ...largest);
  const metrePerNewton = most > 0 ? (0.27 * size) / most : 0;

  // The tips of the arrows belong to the picture.
  const box = { left, right, bottom, top };
  for (const arrow of motion.arrows) {
    const node = motion.nodes[arrow.node];
    for (let frame = 0; frame < Math.max(count(arrow), node.x.length, node.y.length); frame++) {
      const x = pick(node.x, frame) + metrePerNewton * pick(arrow.x, frame);
      const y = pick(node.y, frame) + metrePerNewton * pick(arrow.y, frame);
      box.left = Math.min(box.left, x);
      box.right = Math.max(box.right, x);
      box.bottom = Math.min(box.bottom, y);
      box.top = Math.max(box.top, y);
    }
  }
  // Neither side may vanish.
  const pad = (low, high) => Math.max(0, 0.3 * size - (high - low)) / 2;
  const [padX, padY] = [pad(box.left, box.right), pad(box.bottom, box.top)];
  box.left -= padX;
  box.right += padX;
  box.bottom -= padY;
  box.top += padY;

  // Shapes of one name are one body.
  const colours = new Map();
  const colour = motion.shapes.map((shape, place) => {
    // A gear or rack without a name belongs to the ground.
    const isBody = ["link", "block", "outline"].includes(shape.kind);
    if (!isBody && !(shape.name && ["gear", "rack"].includes(shape.kind))) return -1;
    const key = shape.name || place;
    if (!colours.has(key)) colours.set(key, colours.size % 8);
    return colours.get(key);
  });
  return { box, size, largest, most, metrePerNewton, colour };
}

/** The nodes on the convex hull, in order; bodies are rigid, so that one frame tells it. */
function hull(nodes, ids) {
  const points = ids.map((id) => ({ id, x: nodes[id].x[0], y: nodes[id].y[0] }));
  points.sort((a, b) => a.x - b.x || a.y - b.y);
  const turn = (a, b, c) => (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
  const side = (list) => {
    const chain = [];
    for (const point of list) {
      while (chain.length > 1 && turn(chain[chain.length - 2], chain[chain.length - 1], point) <= 0) chain.pop();
      chain.push(point);
    }
    return chain.slice(0, -1);
  };
  const ring = [...side(points), ...side(points.reverse())].map((point) => point.id);
  return ring.length ? ring : ids;
}

/** Short strokes along a line, on the side given by the sign. */
function hatching(ax, ay, bx, by, depth, sign) {
  const length = Math.hypot(bx - ax, by - ay);
  if (!(length > 0)) return "";
  const [ux, uy] = [(bx - ax) / length, (by - ay) / length];
  const [nx, ny] = [-uy * sign, ux * sign];
  const count = Math.min(Math.max(1, Math.floor(length / (depth * 1.1))), 400);
  let path = "";
  for (let stroke = 0; stroke < count; stroke++) {
    const along = ((stroke + 0.75) * length) / count;
    const [x, y] = [ax + ux * along, ay + uy * along];
    path += `M${round(x)} ${round(y)}l${round((nx - ux) * depth)} ${round((ny - uy) * depth)}`;
  }
  return path;
}

const widths = new Map();

/** The width of a text, measured once; all digits are equally wide. */
function widthOf(text) {
  const key = text.getAttribute("class") + text.textContent.replaceAll(/\d/g, "0");
  if (!widths.has(key)) widths.set(key, text.getComputedTextLength());
  return widths.get(key);
}

/** Draws everything for a size in pixels; gives back what moves it to a time. */
function draw(svg, motion, planned, width, height, isDraft = false) {
  svg.replaceChildren();
  svg.setAttribute("viewBox", `0 0 ${width} ${height}`);
  const { box } = planned;
  const { nodes } = motion;
  const unit = clamp(Math.min(width, height) / 56, 5, 11);

  // Equal scale on both axes; the margins hold the numbers of the grid, symbols and labels.
  const far = Math.max(Math.abs(box.left), Math.abs(box.right), Math.abs(box.bottom), Math.abs(box.top));
  const exponent = exponentFor(far, 0.02, 5000);
  const roughly = (low, high, pixels) => nice(((high - low) / pixels) * 64);
  const step = Math.max(roughly(box.left, box.right, width), roughly(box.bottom, box.top, height));
  const metres = (value) => fixed(value / 10 ** exponent, decimalsOf(step / 10 ** exponent));
  const longest = Math.max(metres(box.bottom).length, metres(box.top).length);
  const edge = { left: 14 + 6.2 * longest, right: width, top: 0, bottom: height - 22 };
  const margin = 3.6 * unit + 8;
  const [roomX, roomY] = [edge.right - edge.left - 2 * margin, edge.bottom - edge.top - 2 * margin];
  const scale = Math.max(Math.min(roomX / (box.right - box.left), roomY / (box.top - box.bottom)), 1e-12);
  const middleX = (edge.left + edge.right) / 2 - (scale * (box.left + box.right)) / 2;
  const middleY = (edge.top + edge.bottom) / 2 + (scale * (box.bottom + box.top)) / 2;
  const place = (node, at) => [middleX + scale * valueAt(node.x, at), middleY - scale * valueAt(node.y, at)];
  // Names keep out of the way over the whole run; while it changes, roughly.
  const count = Math.min(motion.times.length, isDraft ? 8 : 48);
  const samples = Array.from({ length: count }, (_, sample) => {
    return { frame: Math.floor((sample * (motion.times.length - 1)) / (count - 1)), part: 0 };
  });

  // Grid, with its numbers along the edges.
  const grid = element(svg, "g", { class: "qrm-grid" });
  const lines = { thin: "", zero: "" };
  for (const x of multiples((edge.left - middleX) / scale, (edge.right - middleX) / scale, step)) {
    const at = round(middleX + scale * x);
    lines[Math.abs(x) < step / 2 ? "zero" : "thin"] += `M${at} ${edge.top}V${edge.bottom}`;
    if (at > edge.left + 12 && at < edge.right - 58) {
      element(grid, "text", { x: at, y: height - 7, "text-anchor": "middle" }, metres(x));
    }
  }
  for (const y of multiples((middleY - edge.bottom) / scale, (middleY - edge.top) / scale, step)) {
    const at = round(middleY - scale * y);
    lines[Math.abs(y) < step / 2 ? "zero" : "thin"] += `M${edge.left} ${at}H${edge.right}`;
    if (at > edge.top + 8 && at < edge.bottom - 4) {
      element(grid, "text", { x: edge.left - 6, y: at + 3.5, "text-anchor": "end" }, metres(y));
    }
  }
  element(grid, "text", { x: width - 10, y: height - 7, "text-anchor": "end" }, `in ${PREFIXES[exponent]}m`);
  element(grid, "path", { d: lines.thin });
  element(grid, "path", { d: lines.zero, class: "qrm-zero" });

  const layer = (name) => element(svg, "g", { class: `qrm-layer qrm-layer-${name}` });
  const [pathLayer, shapeLayer, forceLayer] = [layer("paths"), layer("shapes"), layer("forces")];
  const [nameLayer, sizeLayer] = [layer("names"), layer("forces")];
  const points = nodes.map(() => [0, 0]);
  const isStill = (id) => nodes[id].x.length === 1 && nodes[id].y.length === 1;
  const text = ([x, y]) => `${round(x)} ${round(y)}`;
  const translate = (id) => `translate(${text(points[id])})`;
  // What has to be done for every time, and what only once.
  const [moving, still] = [[], []];
  const onMove = (ids, work) => (ids.every(isStill) ? still : moving).push(work);
  const owner = new Map();
  const { turn, ...parts } = machineParts({ motion, unit, scale, points, place, moving, onMove, translate, text });
  const builders = {
    ...parts,
    link(group, shape) {
      const ring = shape.nodes.length > 2 ? hull(nodes, shape.nodes) : shape.nodes;
      const kind = shape.nodes.length > 2 ? "polygon" : "polyline";
      const [halo, bar] = ["qrm-halo", "qrm-bar"].map((style) => element(group, kind, { class: style }));
      const pins = shape.nodes.map(() => element(group, "circle", { class: "qrm-pin", r: round(0.62 * unit) }));
      halo.setAttribute("stroke-width", round(1.25 * unit + 3));
      bar.setAttribute("stroke-width", round(1.25 * unit));
      onMove(shape.nodes, () => {
        const outline = ring.map((id) => text(points[id])).join(" ");
        halo.setAttribute("points", outline);
        bar.setAttribute("points", outline);
        pins.forEach((pin, turn) => pin.setAttribute("transform", translate(shape.nodes[turn])));
      });
    },
    block(group, shape) {
      const [long, high] = [5 * unit, 3 * unit];
      const size = { x: -long / 2, y: -high / 2, width: long, height: high, rx: 0.5 * unit };
      element(group, "rect", { ...size, class: "qrm-box" });
      element(group, "circle", { class: "qrm-pin", r: round(0.62 * unit) });
      moving.push((at) => turn(group, shape.node, shape.angle, at));
    },
    rod(group, shape) {
      const line = element(group, "polyline", { class: "qrm-thin" });
      const pins = shape.nodes.map(() => element(group, "circle", { class: "qrm-hub", r: round(0.5 * unit) }));
      onMove(shape.nodes, () => {
        line.setAttribute("points", shape.nodes.map((id) => text(points[id])).join(" "));
        pins.forEach((pin, turn) => pin.setAttribute("transform", translate(shape.nodes[turn])));
      });
    },
    pivot(group, shape) {
      const [half, deep] = [1.7 * unit, 2.5 * unit];
      element(group, "path", { class: "qrm-bearing", d: `M0 0L${-half} ${deep}H${half}Z` });
      const ground = `M${-1.5 * half} ${deep}H${1.5 * half}`;
      const hatch = hatching(-1.5 * half, deep, 1.5 * half, deep, 0.8 * unit, 1);
      element(group, "path", { class: "qrm-hatch", d: ground + hatch });
      element(group, "circle", { class: "qrm-hub", r: round(0.95 * unit) });
      onMove([shape.node], () => group.setAttribute("transform", translate(shape.node)));
    },
    guide(group, shape) {
      const line = element(group, "path", { class: "qrm-rail" });
      const hatch = element(group, "path", { class: "qrm-hatch" });
      // The ground lies on the side away from what moves; a guide that turns keeps the side it has at first.
      const start = shape.nodes.map((id) => place(nodes[id], { frame: 0, part: 0 }));
      const sides = start.slice(1).map(([bx, by], part) => {
        const [ax, ay] = start[part];
        const [cx, cy] = [(edge.left + edge.right) / 2 - ax, (edge.top + edge.bottom) / 2 - ay];
        return (bx - ax) * cy - (by - ay) * cx > 0 ? -1 : 1;
      });
      const aside = shape.is_channel ? 1.5 * unit + 1.5 : 0;
      onMove(shape.nodes, () => {
        let [lines, strokes] = ["", ""];
        for (let part = 1; part < shape.nodes.length; part++) {
          const [[ax, ay], [bx, by]] = [points[shape.nodes[part - 1]], points[shape.nodes[part]]];
          const length = Math.hypot(bx - ax, by - ay) || 1;
          for (const side of shape.is_channel ? [-1, 1] : [sides[part - 1]]) {
            const [x, y] = [((ay - by) / length) * side * aside, ((bx - ax) / length) * side * aside];
            lines += pathOf([[ax + x, ay + y], [bx + x, by + y]]);
            strokes += hatching(ax + x, ay + y, bx + x, by + y, 0.75 * unit, side);
          }
        }
        line.setAttribute("d", lines);
        hatch.setAttribute("d", strokes);
      });
    },
    mass(group, shape) {
      const r = round(0.95 * unit);
      element(group, "circle", { class: "qrm-mass", r });
      const quarters = `M0 0V${-r}A${r} ${r} 0 0 1 ${r} 0H${-r}A${r} ${r} 0 0 0 0 ${r}Z`;
      element(group, "path", { class: "qrm-quarter", d: quarters });
      onMove([shape.node], () => group.setAttribute("transform", translate(shape.node)));
    },
  };
  const nodesOf = (kind) => new Set(motion.shapes.filter((shape) => shape.kind === kind).map((shape) => shape.node));
  const [blocks, pivots] = [nodesOf("block"), nodesOf("pivot")];
  const used = new Set();
  motion.shapes.forEach((shape, index) => {
    const ids = shape.nodes ?? [shape.node];
    const colour = planned.colour[index];
    const group = element(shapeLayer, "g", { class: `qrm-${shape.kind} qrm-c${colour}`, "data-shape": index });
    if (shape.name) {
      group.dataset.name = shape.name;
      element(group, "title", {}, shape.kind === "mass" ? `centre of mass of ${shape.name}` : shape.name);
    }
    for (const id of ids) {
      if (!["guide", "rack", "rail"].includes(shape.kind)) used.add(id);
      if (colour >= 0 && !owner.has(id)) owner.set(id, colour);
    }
    builders[shape.kind](group, shape);
  });
  nodes.forEach((node, id) => {
    // A name or a path without anything at its head would hang in the air.
    if (used.has(id) || !(node.name || node.is_traced || motion.shapes.length === 0)) return;
    const dot = element(shapeLayer, "circle", { class: "qrm-dot", r: round(0.45 * unit) });
    onMove([id], () => dot.setAttribute("transform", translate(id)));
  });

  // Paths: all of it thin, what was just passed stronger.
  const [begin, end] = [motion.times[0], motion.times[motion.times.length - 1]];
  nodes.forEach((node, id) => {
    if (!node.is_traced || isStill(id)) return;
    const group = element(pathLayer, "g", { class: `qrm-path qrm-c${owner.get(id) ?? 0}` });
    const all = motion.times.map((_, frame) => text(place(node, { frame, part: 0 })));
    element(group, "path", { class: "qrm-whole", d: "M" + all.join("L") });
    const tails = [0.12, 0.08, 0.04].map((share) => {
      return [share * (end - begin), element(group, "path", { class: "qrm-tail" })];
    });
    moving.push((at, time) => {
      for (const [past, tail] of tails) {
        const from = locate(motion.times, Math.max(begin, time - past));
        const passed = all.slice(from.frame + 1, at.frame + Math.ceil(at.part));
        tail.setAttribute("d", "M" + [text(place(node, from)), ...passed, text(points[id])].join("L"));
      }
    });
  });

  // Forces.
  const tipOf = (arrow, [x, y], at) => {
    const pixels = planned.metrePerNewton * scale;
    return [x + pixels * valueAt(arrow.x, at), y - pixels * valueAt(arrow.y, at)];
  };
  const labels = [];
  const arrows = motion.arrows.map((arrow, index) => {
    const style = arrow.is_reaction ? "qrm-reaction" : "qrm-load";
    const group = element(forceLayer, "g", { class: `qrm-arrow ${style}` });
    group.dataset.name = arrow.name;
    element(group, "title", {}, arrow.doc ? `${arrow.name}: ${arrow.doc}` : arrow.name);
    const [shaft, head] = ["qrm-shaft", "qrm-tip"].map((part) => element(group, "path", { class: part }));
    // Prefix and decimals stay the same over the run, so that the number can be read while it changes.
    const power = exponentFor(planned.largest[index], 0.1, 1000);
    const most = planned.largest[index] / 10 ** power;
    const decimals = most > 0 ? clamp(2 - Math.floor(Math.log10(most)), 0, 3) : 0;
    const size = (newton) => `${fixed(newton / 10 ** power, decimals)} ${PREFIXES[power]}N`;
    const label = element(sizeLayer, "g", { class: `qrm-size ${style}` });
    const plate = element(label, "rect", { y: -9, height: 18, rx: 5 });
    const words = element(label, "text", { y: 4, "text-anchor": "middle" });
    element(words, "tspan", { class: "qrm-who" }, arrow.name);
    const value = element(words, "tspan", { dx: "0.35em" }, size(planned.largest[index]));
    const half = widthOf(words) / 2 + 4;
    plate.setAttribute("x", round(-half));
    plate.setAttribute("width", round(2 * half));
    const clear = (blocks.has(arrow.node) ? 2.9 : pivots.has(arrow.node) ? 1.2 : 0.9) * unit;
    return { arrow, group, shaft, head, size, label, value, half, clear };
  });
  moving.push((at) => {
    const taken = labels.map(({ id, x, y, half }) => ({ x: points[id][0] + x, y: points[id][1] + y, half }));
    for (const { arrow, group, shaft, head, size, label, value, half, clear } of arrows) {
      const from = points[arrow.node];
      const tip = tipOf(arrow, from, at);
      const length = Math.hypot(tip[0] - from[0], tip[1] - from[1]);
      const strength = clamp((length - 0.5) / 2.5, 0, 1);
      group.setAttribute("opacity", round(strength));
      label.setAttribute("opacity", round(strength));
      if (strength === 0) continue;
      const [ux, uy] = [(tip[0] - from[0]) / length, (tip[1] - from[1]) / length];
      const tall = Math.min(1.5 * unit, 0.6 * length);
      const neck = [tip[0] - ux * tall, tip[1] - uy * tall];
      const wing = (sign) => text([neck[0] - sign * uy * tall * 0.38, neck[1] + sign * ux * tall * 0.38]);
      shaft.setAttribute("d", `M${text(from)}L${text(neck)}`);
      head.setAttribute("d", `M${text(tip)}L${wing(1)}L${wing(-1)}Z`);
      value.textContent = size(Math.hypot(valueAt(arrow.x, at), valueAt(arrow.y, at)));
      // Beyond the tip and the symbol at the node, moved aside by the shorter way where another label is.
      const reach = Math.max(length + 3, clear) + half * Math.abs(ux) + 9 * Math.abs(uy);
      const own = { x: from[0] + ux * reach, y: from[1] + uy * reach, half };
      for (const other of taken) {
        const [dx, dy] = [own.x - other.x, own.y - other.y];
        const [overX, overY] = [own.half + other.half + 2 - Math.abs(dx), 17 - Math.abs(dy)];
        if (overX <= 0 || overY <= 0) continue;
        if (overX < overY) own.x += dx < 0 ? -overX : overX;
        else own.y += dy < 0 ? -overY : overY;
      }
      // Kept inside, and then not upon the tip.
      const inside = clamp(own.x, edge.left + half + 3, Math.max(edge.left + half + 3, edge.right - half - 3));
      own.y += (uy > 0.15 ? 1 : -1) * Math.min(17, 2 * Math.abs(own.x - inside));
      own.x = inside;
      own.y = clamp(own.y, edge.top + 11, edge.bottom - 10);
      taken.push(own);
      label.setAttribute("transform", `translate(${text([own.x, own.y])})`);
    }
  });

  // Names stand at a fixed offset from their nodes: the one that is least in the way over the whole run.
  const segments = samples.map((at) => {
    const where = nodes.map((node) => place(node, at));
    const list = where.map((point) => [point, point]);
    for (const shape of motion.shapes) {
      const ids = shape.kind === "belt" ? [] : (shape.nodes ?? []);
      for (let part = 1; part < ids.length; part++) list.push([where[ids[part - 1]], where[ids[part]]]);
      if (ids.length > 2) list.push([where[ids[ids.length - 1]], where[ids[0]]]);
      if (shape.kind === "pivot") {
        const [x, y] = where[shape.node];
        const ground = y + 2.5 * unit;
        list.push([[x, y], [x, ground]], [[x - 2.5 * unit, ground], [x + 2.5 * unit, ground]]);
      }
    }
    for (const arrow of motion.arrows) list.push([where[arrow.node], tipOf(arrow, where[arrow.node], at)]);
    return { where, list };
  });
  nodes.forEach((node, id) => {
    if (!node.name) return;
    const label = element(nameLayer, "text", { class: "qrm-name", "text-anchor": "middle" }, node.name);
    const half = widthOf(label) / 2;
    const gap = (blocks.has(id) ? 2.4 : pivots.has(id) ? 1.5 : 1.1) * unit;
    let best = { cost: Infinity };
    for (let eighth = 0; eighth < 8; eighth++) {
      const [dx, dy] = [Math.cos((eighth * Math.PI) / 4), -Math.sin((eighth * Math.PI) / 4)];
      const [x, y] = [dx * (half + gap), dy * (7 + gap)];
      // Where all are equal, above to the right is the habit.
      let cost = eighth === 1 ? 0 : 0.01 * samples.length;
      for (const { where, list } of segments) {
        const [px, py] = [where[id][0] + x, where[id][1] + y];
        for (const [a, b] of list) cost += nearness(px, py, a, b, half + 4, 11);
        for (const other of labels) {
          const [ox, oy] = [where[other.id][0] + other.x - px, where[other.id][1] + other.y - py];
          if (Math.abs(ox) < half + other.half + 2 && Math.abs(oy) < 14) cost += 3;
        }
        if (px - half < edge.left || px + half > edge.right || py < edge.top + 8 || py > edge.bottom - 8) cost += 3;
      }
      if (cost < best.cost) best = { cost, id, x, y, half };
    }
    labels.push(best);
    onMove([id], () => {
      const [x, y] = [points[id][0] + best.x, points[id][1] + best.y + 4];
      label.setAttribute("transform", `translate(${text([x, y])})`);
    });
  });

  const settle = (at) => nodes.forEach((node, id) => ([points[id][0], points[id][1]] = place(node, at)));
  settle({ frame: 0, part: 0 });
  for (const work of still) work({ frame: 0, part: 0 }, begin);
  const update = (time) => {
    const at = locate(motion.times, time);
    settle(at);
    for (const work of moving) work(at, time);
  };
  const toMetres = (x, y) => [(x - middleX) / scale, (middleY - y) / scale];
  return { update, pixelPerNewton: planned.metrePerNewton * scale, points, toMetres, scale };
}

/** From 0 to 1: how deep a segment lies in the ellipse of half axes `wide` and `high` around a point. */
function nearness(px, py, [ax, ay], [bx, by], wide, high) {
  const [x, y] = [(px - ax) / wide, (py - ay) / high];
  const [dx, dy] = [(bx - ax) / wide, (by - ay) / high];
  const square = dx * dx + dy * dy;
  const along = square > 0 ? clamp((x * dx + y * dy) / square, 0, 1) : 0;
  return Math.max(0, 1 - Math.hypot(x - along * dx, y - along * dy));
}
