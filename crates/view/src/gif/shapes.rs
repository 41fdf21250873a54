//! Draws the moving parts.

use crate::motion::{Arrow, Motion, Shape};

use super::canvas::Canvas;
use super::hull::hull;
use super::palette::{BODIES, FIXED, GROUND, GUIDE, INK, LOAD, PIN, REACTION, Rgb, TRACE};
use super::stage::{Point, Stage, frame_along};
use super::track::{Moment, angle, value};
use super::{force_elements, teeth};

/// Half the width of a bar, and the width of its edge.
const BAR: f32 = 5.5;
const EDGE: f32 = 1.6;

/// Draws the paths of traced nodes.
pub(super) fn draw_traces(canvas: &mut Canvas, motion: &Motion, stage: &Stage) {
    for node in motion.nodes.iter().filter(|node| node.is_traced) {
        let path: Vec<Point> = (0..motion.times.len()).map(|i| stage.to_picture(node, Moment::from_frame(i))).collect();
        canvas.line(&path, 1.1, TRACE);
    }
}

/// Draws all shapes and forces at a moment.
pub(super) fn draw(canvas: &mut Canvas, motion: &Motion, stage: &Stage, moment: Moment) {
    let to_picture = |node: usize| stage.to_picture(&motion.nodes[node], moment);
    let all = |nodes: &[usize]| nodes.iter().map(|node| to_picture(*node)).collect::<Vec<_>>();
    let colours = colours(motion);
    for (shape, colour) in motion.shapes.iter().zip(colours) {
        let turned = |node: usize, track: &[f64], places: &[[f64; 2]]| {
            let angle = angle(track, moment);
            let to_picture = |place: &[f64; 2]| stage.to_picture_in_frame(&motion.nodes[node], angle, *place, moment);
            places.iter().map(to_picture).collect::<Vec<_>>()
        };
        match shape {
            Shape::Link { nodes, .. } => {
                let corners = if nodes.len() > 2 { hull(&motion.nodes, nodes) } else { nodes.clone() };
                draw_link(canvas, &all(&corners), colour);
            }
            Shape::Block { node, angle: track, .. } => {
                draw_block(canvas, to_picture(*node), angle(track, moment), colour)
            }
            Shape::Pivot { node } => draw_pivot(canvas, to_picture(*node)),
            Shape::Guide { nodes, is_channel: false } => canvas.line(&all(nodes), 1.5, GUIDE),
            Shape::Guide { nodes, is_channel: true } => draw_channel(canvas, &all(nodes)),
            Shape::Mass { node, .. } => draw_mass(canvas, to_picture(*node)),
            Shape::Rod { nodes, .. } => canvas.line(&all(nodes), 2.2, INK),
            Shape::ForceElement { nodes, parts, .. } => {
                let [Some(from), Some(to)] = [nodes.first(), nodes.last()] else { continue };
                let range = distances(motion, stage, *from, *to);
                force_elements::draw(canvas, parts, [to_picture(*from), to_picture(*to)], range);
            }
            Shape::Gear { node, angle, radius, teeth, phase, is_internal, .. } => {
                let outline = turned(*node, angle, &teeth::gear(*radius, *teeth, *phase, *is_internal));
                if *is_internal {
                    let rim = turned(*node, angle, &teeth::rim(*radius, *teeth));
                    canvas.ring(&rim, &outline, colour.0);
                    canvas.outline(&rim, EDGE, colour.1);
                } else {
                    canvas.polygon(&outline, colour.0, 255);
                    let hub = 0.25 * radius;
                    let mark = turned(*node, angle, &[hub, 0.8 * radius].map(|along| along_angle(along, *phase)));
                    canvas.line(&mark, 1.2, colour.1);
                }
                canvas.outline(&outline, EDGE, colour.1);
            }
            Shape::Rack { node, angle, along, across, pitch, phase, .. } => {
                let outline = turned(*node, angle, &teeth::rack(*along, *across, *pitch, *phase));
                canvas.polygon(&outline, colour.0, 255);
                canvas.outline(&outline, EDGE, colour.1);
            }
            Shape::Rail { node, angle, along } => {
                let ends = turned(*node, angle, &along.map(|along| [along, 0.0]));
                canvas.line(&ends, 5.0, GROUND);
                canvas.line(&ends, 5.0 - 2.0 * 1.3, PIN);
            }
            Shape::Belt { nodes, radii, is_crossed, angle: track, .. } => {
                let [first, second] =
                    [nodes.first(), nodes.last()].map(|node| node.map_or((0.0, 0.0), |n| to_picture(*n)));
                let radii = radii.map(|radius| stage.length(radius));
                draw_belt(canvas, [first, second], radii, *is_crossed, angle(track, moment) as f32);
            }
            Shape::Outline { node, angle, x, y, .. } => {
                let corners: Vec<[f64; 2]> = x.iter().zip(y).map(|(x, y)| [*x, *y]).collect();
                let outline = turned(*node, angle, &corners);
                canvas.polygon(&outline, colour.0, 255);
                canvas.outline(&outline, EDGE, colour.1);
            }
        }
    }
    // Joints connect shapes above and below, and are drawn on top of both.
    for shape in &motion.shapes {
        let pins = match shape {
            Shape::Link { nodes, .. } | Shape::Rod { nodes, .. } => &nodes[..],
            Shape::Gear { node, is_internal: false, .. } | Shape::Outline { node, .. } => std::slice::from_ref(node),
            _ => continue,
        };
        for (x, y) in all(pins) {
            canvas.disc((x, y), 4.2, INK);
            canvas.disc((x, y), 2.8, PIN);
        }
    }
    for arrow in &motion.arrows {
        let force = stage.arrow((value(&arrow.x, moment), value(&arrow.y, moment)));
        draw_arrow(canvas, to_picture(arrow.node), force, colour_of(arrow));
    }
}

/// Fill and edge colours of each shape. Shapes with one name are one body; a gear or rack without a name belongs to the
/// ground.
fn colours(motion: &Motion) -> Vec<(Rgb, Rgb)> {
    let mut bodies: Vec<String> = Vec::new();
    let mut colour = |(place, shape): (usize, &Shape)| {
        let has_name = !shape.name().is_empty();
        let is_body = match shape {
            Shape::Link { .. } | Shape::Block { .. } | Shape::Outline { .. } => true,
            Shape::Gear { .. } | Shape::Rack { .. } => has_name,
            _ => false,
        };
        if !is_body {
            return FIXED;
        }
        let name = if has_name { shape.name().to_owned() } else { place.to_string() };
        let number = bodies.iter().position(|body| *body == name).unwrap_or(bodies.len());
        if number == bodies.len() {
            bodies.push(name);
        }
        BODIES[number % BODIES.len()]
    };
    motion.shapes.iter().enumerate().map(&mut colour).collect()
}

/// The smallest and the largest distance of two nodes.
fn distances(motion: &Motion, stage: &Stage, from: usize, to: usize) -> [f32; 2] {
    let apart = |frame: usize| {
        let [(ax, ay), (bx, by)] =
            [from, to].map(|node| stage.to_picture(&motion.nodes[node], Moment::from_frame(frame)));
        (bx - ax).hypot(by - ay)
    };
    let grown = |[low, high]: [f32; 2], length: f32| [low.min(length), high.max(length)];
    (0..motion.times.len()).map(apart).fold([f32::INFINITY, 0.0], grown)
}

fn along_angle(along: f64, angle: f64) -> [f64; 2] {
    [along * angle.cos(), along * angle.sin()]
}

/// The colour of a force.
pub(super) fn colour_of(arrow: &Arrow) -> Rgb {
    if arrow.is_reaction { REACTION } else { LOAD }
}

/// Draws a bar, or a plate if there are more than two nodes.
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
    // A wide outline rounds the corners.
    const CORNER: f32 = 4.0;
    let (sin, cos) = (angle.sin() as f32, angle.cos() as f32);
    let corners = [(-14.0, -7.0), (14.0, -7.0), (14.0, 7.0), (-14.0, 7.0)];
    let corners = corners.map(|(along, across)| (x + along * cos + across * sin, y - along * sin + across * cos));
    for (colour, width) in [(edge, 2.0 * CORNER), (inside, 2.0 * (CORNER - EDGE))] {
        canvas.polygon(&corners, colour, 255);
        canvas.outline(&corners, width, colour);
    }
}

/// Draws hatched walls on both sides of a block.
fn draw_channel(canvas: &mut Canvas, places: &[Point]) {
    const ASIDE: f32 = 12.5;
    let [from, .., to] = *places else { return };
    let Some((length, at)) = frame_along(from, to) else { return };
    let strokes = (length / 7.0).floor().clamp(1.0, 200.0) as u32;
    for side in [-1.0, 1.0] {
        canvas.line(&[at(0.0, side * ASIDE), at(length, side * ASIDE)], 1.5, GROUND);
        for stroke in 0..strokes {
            let along = length * (stroke as f32 + 0.75) / strokes as f32;
            canvas.line(&[at(along, side * ASIDE), at(along - 5.0, side * (ASIDE + 5.0))], 1.0, GUIDE);
        }
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

/// Draws a disc with two of its quarters filled.
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

/// Draws two pulleys, each with a spoke, and the belt around them.
fn draw_belt(canvas: &mut Canvas, centres: [Point; 2], radii: [f32; 2], is_crossed: bool, angle: f32) {
    let [first, second] = centres;
    let line = (first.1 - second.1).atan2(second.0 - first.0);
    let ratio = if is_crossed { -radii[0] / radii[1] } else { radii[0] / radii[1] };
    for (centre, radius, turned) in [(first, radii[0], angle), (second, radii[1], ratio * angle)] {
        canvas.disc(centre, radius, GUIDE);
        canvas.disc(centre, radius - 1.2, PIN);
        let (sin, cos) = (line + turned).sin_cos();
        let rim = |sign: f32| (centre.0 + sign * 0.9 * radius * cos, centre.1 - sign * 0.9 * radius * sin);
        canvas.line(&[rim(-1.0), rim(1.0)], 1.2, GUIDE);
    }
    let wide = |(x, y): Point| [f64::from(x), f64::from(y)];
    let belt = teeth::belt(wide(first), wide(second), radii.map(f64::from), is_crossed);
    let belt: Vec<Point> = belt.into_iter().map(|[x, y]| (x as f32, y as f32)).collect();
    canvas.outline(&belt, 2.6, INK);
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
