//! Draws what moves.

use crate::motion::{Arrow, Motion, Shape};

use super::canvas::Canvas;
use super::palette::{BODIES, GROUND, GUIDE, INK, LOAD, PIN, REACTION, Rgb, TRACE};
use super::stage::{Point, Stage};
use super::track::{Moment, angle, value};

/// Half the width of a bar, and the width of its edge.
const BAR: f32 = 5.5;
const EDGE: f32 = 1.6;

/// Draws the paths of traced nodes.
pub(super) fn draw_traces(canvas: &mut Canvas, motion: &Motion, stage: &Stage) {
    for node in motion.nodes.iter().filter(|node| node.is_traced) {
        let path: Vec<Point> = (0..motion.times.len()).map(|i| stage.seen(node, Moment::of_frame(i))).collect();
        canvas.line(&path, 1.1, TRACE);
    }
}

/// Draws all shapes and forces at a moment.
pub(super) fn draw(canvas: &mut Canvas, motion: &Motion, stage: &Stage, moment: Moment) {
    let seen = |node: usize| stage.seen(&motion.nodes[node], moment);
    let all = |nodes: &[usize]| nodes.iter().map(|node| seen(*node)).collect::<Vec<_>>();
    let mut bodies = BODIES.iter().cycle();
    let mut body = || bodies.next().copied().unwrap_or(BODIES[0]);
    for shape in &motion.shapes {
        match shape {
            Shape::Link { nodes, .. } => draw_link(canvas, &all(nodes), body()),
            Shape::Block { node, angle: track, .. } => draw_block(canvas, seen(*node), angle(track, moment), body()),
            Shape::Pivot { node } => draw_pivot(canvas, seen(*node)),
            Shape::Guide { nodes } => canvas.line(&all(nodes), 1.5, GUIDE),
            Shape::Mass { node, .. } => draw_mass(canvas, seen(*node)),
        }
    }
    // Joints connect what lies above and below: they are seen on top of both.
    for shape in &motion.shapes {
        let Shape::Link { nodes, .. } = shape else { continue };
        for (x, y) in all(nodes) {
            canvas.disc((x, y), 4.2, INK);
            canvas.disc((x, y), 2.8, PIN);
        }
    }
    for arrow in &motion.arrows {
        let force = stage.arrow((value(&arrow.x, moment), value(&arrow.y, moment)));
        draw_arrow(canvas, seen(arrow.node), force, colour_of(arrow));
    }
}

/// The colour of a force.
pub(super) fn colour_of(arrow: &Arrow) -> Rgb {
    if arrow.is_reaction { REACTION } else { LOAD }
}

/// A bar, or a plate if there are more nodes than two.
fn draw_link(canvas: &mut Canvas, places: &[Point], (inside, edge): (Rgb, Rgb)) {
    match places {
        [] => {}
        [place] => {
            canvas.disc(*place, BAR, edge);
            canvas.disc(*place, BAR - EDGE, inside);
        }
        [_, _] => {
            canvas.line(places, 2.0 * BAR, edge);
            canvas.line(places, 2.0 * (BAR - EDGE), inside);
        }
        _ => {
            canvas.polygon(places, inside, 120);
            canvas.outline(places, 2.0 * BAR, edge);
            canvas.outline(places, 2.0 * (BAR - EDGE), inside);
        }
    }
}

fn draw_block(canvas: &mut Canvas, (x, y): Point, angle: f64, (inside, edge): (Rgb, Rgb)) {
    // Wide outlines round the corners.
    const CORNER: f32 = 4.0;
    let (sin, cos) = (angle.sin() as f32, angle.cos() as f32);
    let corners = [(-14.0, -7.0), (14.0, -7.0), (14.0, 7.0), (-14.0, 7.0)];
    let corners = corners.map(|(along, across)| (x + along * cos + across * sin, y - along * sin + across * cos));
    for (colour, width) in [(edge, 2.0 * CORNER), (inside, 2.0 * (CORNER - EDGE))] {
        canvas.polygon(&corners, colour, 255);
        canvas.outline(&corners, width, colour);
    }
}

fn draw_pivot(canvas: &mut Canvas, (x, y): Point) {
    let ground = y + 19.0;
    for i in 0..6 {
        let x = x - 15.0 + 6.6 * i as f32;
        canvas.line(&[(x, ground), (x - 5.0, ground + 6.0)], 1.0, GROUND);
    }
    let corners = [(x, y), (x + 11.0, ground), (x - 11.0, ground)];
    canvas.polygon(&corners, PIN, 255);
    canvas.outline(&corners, 1.5, GROUND);
    canvas.line(&[(x - 19.0, ground), (x + 19.0, ground)], 1.8, GROUND);
    canvas.disc((x, y), 5.4, GROUND);
    canvas.disc((x, y), 4.0, PIN);
}

/// A disc with two of its quarters filled.
fn draw_mass(canvas: &mut Canvas, (x, y): Point) {
    const RADIUS: f32 = 5.0;
    canvas.disc((x, y), RADIUS + 1.0, INK);
    canvas.disc((x, y), RADIUS, PIN);
    for start in [0.0, std::f32::consts::PI] {
        let rim = (0..=8).map(|i| start + std::f32::consts::FRAC_PI_2 * i as f32 / 8.0);
        let rim = rim.map(|angle| (x + RADIUS * angle.cos(), y - RADIUS * angle.sin()));
        let quarter: Vec<Point> = std::iter::once((x, y)).chain(rim).collect();
        canvas.polygon(&quarter, INK, 255);
    }
}

fn draw_arrow(canvas: &mut Canvas, (x, y): Point, (dx, dy): Point, colour: Rgb) {
    let length = dx.hypot(dy);
    if length < 1.5 {
        return;
    }
    let (along, across) = ((dx / length, dy / length), (-dy / length, dx / length));
    let head = (0.6 * length).min(12.0);
    let at =
        |forward: f32, aside: f32| (x + forward * along.0 + aside * across.0, y + forward * along.1 + aside * across.1);
    canvas.line(&[(x, y), at(length - 0.8 * head, 0.0)], 2.4, colour);
    canvas.polygon(&[at(length, 0.0), at(length - head, 0.38 * head), at(length - head, -0.38 * head)], colour, 255);
}
