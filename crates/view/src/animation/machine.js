// Springs, gears, racks, belts and cams: what builds them, and moves them.

/** The builders of these parts in a drawing, and what turns a group. */
function machineParts({ motion, unit, scale, points, place, moving, onMove, translate, text }) {
  /** Moves a group to a node, turned by an angle counter-clockwise. */
  const turn = (group, node, angle, at) => {
    const degrees = round((-angleAt(angle, at) * 180) / Math.PI);
    group.setAttribute("transform", `${translate(node)} rotate(${degrees})`);
  };
  const { nodes } = motion;
  const hub = (group) => element(group, "circle", { class: "qrm-pin", r: round(0.62 * unit) });
  return {
    turn,
    forceElement(group, shape) {
      const styles = ["qrm-around", "qrm-area-of", "qrm-lines", "qrm-solid"];
      const [around, areas, lines, solids] = styles.map((style) => element(group, "path", { class: style }));
      const ends = shape.nodes.map(() => element(group, "circle", { class: "qrm-solid", r: round(0.38 * unit) }));
      const [from, to] = shape.nodes;
      const lengths = motion.times.map((_, frame) => {
        const [[ax, ay], [bx, by]] = [from, to].map((id) => place(nodes[id], { frame, part: 0 }));
        return Math.hypot(bx - ax, by - ay);
      });
      const range = rangeOf([lengths]);
      onMove(shape.nodes, () => {
        const [[ax, ay], [bx, by]] = [points[from], points[to]];
        const length = Math.hypot(bx - ax, by - ay);
        const paths = forceElementPaths(shape.parts, length, range, unit);
        around.setAttribute("d", paths.lines);
        areas.setAttribute("d", paths.areas);
        lines.setAttribute("d", paths.lines);
        solids.setAttribute("d", paths.solids);
        ends[1].setAttribute("cx", round(length));
        const degrees = round((Math.atan2(by - ay, bx - ax) * 180) / Math.PI);
        group.setAttribute("transform", `translate(${text([ax, ay])}) rotate(${degrees})`);
      });
    },
    gear(group, shape) {
      const style = shape.is_internal ? "qrm-body qrm-ring" : "qrm-body";
      element(group, "path", { class: style, d: gearPath(shape, scale) });
      const r = round(scale * shape.radius);
      element(group, "circle", { class: "qrm-pitch", r });
      if (!shape.is_internal) {
        const mark = [0.3, 0.8].map((part) => polar(part * r, shape.phase));
        element(group, "path", { class: "qrm-spoke", d: pathOf(mark) });
        hub(group);
      }
      moving.push((at) => turn(group, shape.node, shape.angle, at));
    },
    rack(group, shape) {
      element(group, "path", { class: "qrm-body", d: rackPath(shape, scale) });
      moving.push((at) => turn(group, shape.node, shape.angle, at));
    },
    rail(group, shape) {
      const [from, to] = shape.along.map((along) => round(scale * along));
      for (const style of ["qrm-slot", "qrm-gap"]) {
        const width = round(style === "qrm-slot" ? 0.7 * unit : 0.7 * unit - 2.4);
        element(group, "path", { class: style, d: `M${from} 0H${to}`, "stroke-width": Math.max(width, 1) });
      }
      moving.push((at) => turn(group, shape.node, shape.angle, at));
    },
    belt(group, shape) {
      const radii = shape.radii.map((radius) => scale * radius);
      const pulleys = radii.map((radius) => {
        const pulley = element(group, "g");
        element(pulley, "circle", { class: "qrm-pulley", r: round(radius) });
        const [far, near] = [round(0.92 * radius), round(Math.min(0.8 * unit, radius))];
        element(pulley, "path", { class: "qrm-spoke", d: `M${near} 0H${far}M${-near} 0H${-far}M0 ${near}V${far}M0 ${-near}V${-far}` });
        hub(pulley);
        return pulley;
      });
      const [belt, marks] = ["qrm-strap", "qrm-marks"].map((style) => element(group, "path", { class: style }));
      for (const each of [belt, marks]) each.setAttribute("stroke-width", round(0.42 * unit));
      marks.setAttribute("stroke-dasharray", `1.2 ${round(4 * unit - 1.2)}`);
      const ratio = ((shape.is_crossed ? -1 : 1) * shape.radii[0]) / shape.radii[1];
      moving.push((at) => {
        const [first, second] = shape.nodes.map((id) => points[id]);
        const path = beltPath(first, second, radii, shape.is_crossed);
        belt.setAttribute("d", path);
        marks.setAttribute("d", path);
        const line = Math.atan2(first[1] - second[1], second[0] - first[0]);
        const angle = angleAt(shape.angle, at);
        marks.setAttribute("stroke-dashoffset", round((-radii[0] * angle) % (4 * unit)));
        pulleys.forEach((pulley, which) => turn(pulley, shape.nodes[which], [line + angle * (which ? ratio : 1)], at));
      });
    },
    outline(group, shape) {
      const places = shape.x.map((x, corner) => [scale * x, -scale * shape.y[corner]]);
      element(group, "path", { class: "qrm-body", d: pathOf(places) + "Z" });
      hub(group);
      moving.push((at) => turn(group, shape.node, shape.angle, at));
    },
  };
}
