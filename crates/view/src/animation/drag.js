// Bodies that are dragged by the mouse: the motion starts from where they are let go.

let isDragged = false;

/** The place of the pointer in the drawing, in pixels. */
function pixels({ clientX, clientY }) {
  const bounds = part("canvas").getBoundingClientRect();
  return [clientX - bounds.left, clientY - bounds.top];
}

/** The shapes under the pointer, the topmost first. */
function shapesUnder({ clientX, clientY }) {
  // Arrows may lie above them.
  const below = document.elementsFromPoint(clientX, clientY).map((each) => each.closest("[data-shape]"));
  return [...new Set(below)].map((each) => motion.shapes[each?.dataset.shape]).filter((each) => each);
}

/** The points of the topmost body under the pointer that moves, with their weights in the place that is held, by names. */
function grabbedPoints(event, x, y) {
  if (!drawing) return null;
  for (const shape of shapesUnder(event)) {
    if (shape.kind === "pivot") return null;
    const points = pointsOf(shape, x, y);
    if (points) return points;
  }
  return null;
}

/** The points of a shape that are next to a place, or of others that are of one body with it. */
function pointsOf(shape, x, y) {
  const at = drawing.points;
  const names = (id) => motion.nodes[id].name;
  const moves = (id) => motion.nodes[id].x.length > 1 || motion.nodes[id].y.length > 1;
  let best = { distance: Infinity, points: null };
  const offer = (points, px, py) => {
    const distance = Math.hypot(px - x, py - y);
    const ends = Object.keys(points);
    if (distance < best.distance && ends.length > 0) best = { distance, points };
  };
  const isOfBody = (each) => each === shape || (shape.name && each.name === shape.name);
  for (const each of motion.shapes.filter(isOfBody)) {
    const ids = each.nodes ?? [each.node];
    for (const id of ids) if (names(id) && moves(id)) offer({ [names(id)]: 1 }, ...at[id]);
    ids.slice(1).forEach((b, place) => {
      const a = ids[place];
      if (!names(a) || !names(b) || !(moves(a) || moves(b))) return;
      const [[ax, ay], [bx, by]] = [at[a], at[b]];
      const [dx, dy] = [bx - ax, by - ay];
      const share = clamp(((x - ax) * dx + (y - ay) * dy) / (dx * dx + dy * dy || 1), 0, 1);
      // A wheel is turned by a point that moves: its axis would stay where it is.
      if (each !== shape && !((share < 1 && moves(a)) || (share > 0 && moves(b)))) return;
      offer({ [names(a)]: 1 - share, [names(b)]: share }, ax + share * dx, ay + share * dy);
    });
  }
  return best.points;
}

/** The time at which points were nearest to a place; where several are as near, the one next to the time shown. */
function nearestTime(points, x, y) {
  const nodes = Object.entries(points).map(([name, weight]) => [motion.nodes.find((node) => node.name === name), weight]);
  const distances = times.map((_, frame) => {
    const place = (axis) => nodes.reduce((sum, [node, weight]) => sum + weight * valueAt(node[axis], { frame, part: 0 }), 0);
    return Math.hypot(place("x") - x, place("y") - y);
  });
  const least = Math.min(...distances);
  const near = times.filter((_, frame) => distances[frame] <= least + 0.02 * planned.size);
  return near.reduce((best, each) => (Math.abs(each - time) < Math.abs(best - time) ? each : best), near[0]);
}

/** Ends the drag, if there is one, and leaves the motion as it is. */
let endDrag = () => {};

part("canvas").addEventListener("pointerdown", (event) => {
  const canvas = part("canvas");
  const points = event.button === 0 && !isDragged ? grabbedPoints(event, ...pixels(event)) : null;
  if (!points) return;
  event.preventDefault();
  canvas.setPointerCapture(event.pointerId);
  const wasPlaying = isPlaying;
  const { toMetres } = drawing;
  let [from, place, hasMoved] = [time, null, false];
  play(false);
  isDragged = true;
  root.toggleAttribute("data-dragged", true);
  const follow = () => {
    if (!place) return;
    const [x, y] = toMetres(...place);
    [place, hasMoved] = [null, true];
    if (about.start.length === 0) return show(nearestTime(points, x, y));
    try {
      const start = simulated.drag(from, x, y, points);
      from = NaN;
      for (const name in start) {
        setValue(name, start[name]);
        rows.get(name)(start[name]);
      }
      time = begin;
      recompute(true);
    } catch (problem) {
      setText("problem", problem.message);
    }
  };
  const moved = (next) => {
    if (next.pointerId !== event.pointerId) return;
    if (!place) requestAnimationFrame(follow);
    place = pixels(next);
  };
  const released = (next) => {
    if (next.pointerId !== event.pointerId) return;
    follow();
    endDrag();
    if (hasMoved && about.start.length > 0) recompute();
  };
  endDrag = () => {
    canvas.removeEventListener("pointermove", moved);
    for (const name of ["pointerup", "pointercancel"]) canvas.removeEventListener(name, released);
    [isDragged, place, endDrag] = [false, null, () => {}];
    root.toggleAttribute("data-dragged", false);
    if (wasPlaying) play(true);
  };
  canvas.addEventListener("pointermove", moved);
  for (const name of ["pointerup", "pointercancel"]) canvas.addEventListener(name, released);
});
