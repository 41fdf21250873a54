//! The placement of node names.

use embedded_graphics::mono_font::MonoFont;
use embedded_graphics::mono_font::ascii::FONT_7X13;

use crate::motion::{Motion, Shape};

use super::canvas::Canvas;
use super::palette::INK;
use super::stage::{Point, Stage};
use super::track::Moment;

const FONT: &MonoFont<'_> = &FONT_7X13;
const LETTER: (f32, f32) = (7.0, 13.0);
/// The number of moments of the motion at which overlaps are tested.
const LOOKS: usize = 12;

/// The name of a node, always on the same side of it, so that it does not jump.
#[derive(Clone, Debug)]
pub(super) struct Label {
    node: usize,
    text: String,
    /// The vector from the node to the upper left corner of the name.
    offset: Point,
}

/// Places the names of all named nodes.
pub(super) fn place_labels(motion: &Motion, stage: &Stage) -> Vec<Label> {
    let frames = motion.times.len();
    let moments: Vec<Moment> = (0..LOOKS).map(|i| Moment::from_frame(i * (frames - 1) / (LOOKS - 1))).collect();
    let mut labels: Vec<Label> = Vec::new();
    for (node, named) in motion.nodes.iter().enumerate().filter(|(_, n)| !n.name.is_empty()) {
        let text = plain(&named.name);
        let width = LETTER.0 * text.len() as f32;
        let is_block = |shape: &Shape| matches!(shape, Shape::Block { node: of, .. } if *of == node);
        // Blocks are larger than joints.
        let gap = if motion.shapes.iter().any(is_block) { 17.0 } else { 8.0 };
        let (right, left, above, below) = (gap + 1.0, -gap - 1.0 - width, -gap - LETTER.1, gap);
        let (middle, level) = (-0.5 * width, -0.5 * LETTER.1);
        let sides = [(right, above), (left, above), (right, below), (left, below)];
        let sides = sides.into_iter().chain([(right + 3.0, level), (left - 3.0, level), (middle, above - 3.0)]);
        let candidates = sides.map(|offset| Label { node, text: text.clone(), offset });
        let cost = |label: &Label| moments.iter().map(|at| label.cost(motion, stage, *at, &labels)).sum::<u32>();
        // The first of several equal ones.
        let best = candidates.min_by_key(cost);
        labels.extend(best);
    }
    labels
}

/// Replaces characters outside ASCII, which the font lacks.
pub(super) fn plain(text: &str) -> String {
    text.chars().map(|c| if c.is_ascii_graphic() || c == ' ' { c } else { '?' }).collect()
}

impl Label {
    /// Writes the name.
    pub(super) fn draw(&self, canvas: &mut Canvas, motion: &Motion, stage: &Stage, moment: Moment) {
        let corner = self.corner(motion, stage, moment);
        canvas.write(&self.text, FONT, (corner.0.round() as i32, corner.1.round() as i32), INK);
    }

    fn corner(&self, motion: &Motion, stage: &Stage, moment: Moment) -> Point {
        let (x, y) = stage.to_picture(&motion.nodes[self.node], moment);
        (x + self.offset.0, y + self.offset.1)
    }

    fn width(&self) -> f32 {
        LETTER.0 * self.text.len() as f32
    }

    /// The amount of overlap at a moment.
    fn cost(&self, motion: &Motion, stage: &Stage, moment: Moment, others: &[Self]) -> u32 {
        let (x, y) = self.corner(motion, stage, moment);
        let (width, height) = (self.width(), LETTER.1);
        let covers = |place: Point, rim: f32| {
            (x - rim..=x + width + rim).contains(&place.0) && (y - rim..=y + height + rim).contains(&place.1)
        };
        let is_outside = x < 0.0 || y < 0.0 || x + width > stage.width as f32 || y + height > stage.height as f32;
        let is_crowded = |other: &&Self| {
            let (left, top) = other.corner(motion, stage, moment);
            x < left + other.width() && left < x + width && y < top + height && top < y + height
        };
        let to_picture = |node: usize| stage.to_picture(&motion.nodes[node], moment);
        let crossed = motion.shapes.iter().map(|shape| match shape {
            Shape::Link { nodes, .. }
            | Shape::Guide { nodes, .. }
            | Shape::Rod { nodes, .. }
            | Shape::ForceElement { nodes, .. }
            | Shape::Belt { nodes, .. } => nodes
                .windows(2)
                .filter(|pair| along(to_picture(pair[0]), to_picture(pair[1])).any(|place| covers(place, 4.0)))
                .count(),
            Shape::Block { node, .. } => usize::from(*node != self.node && covers(to_picture(*node), 12.0)),
            Shape::Pivot { node } => usize::from(covers((to_picture(*node).0, to_picture(*node).1 + 12.0), 10.0)),
            Shape::Mass { node, .. } => usize::from(covers(to_picture(*node), 5.0)),
            // Names cannot avoid these.
            Shape::Gear { .. } | Shape::Rack { .. } | Shape::Rail { .. } | Shape::Outline { .. } => 0,
        });
        let crossed = crossed.sum::<usize>() as u32;
        crossed + 4 * others.iter().filter(is_crowded).count() as u32 + 8 * u32::from(is_outside)
    }
}

/// Closely spaced positions on a line.
fn along(from: Point, to: Point) -> impl Iterator<Item = Point> {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let steps = (dx.hypot(dy) / 5.0).ceil().clamp(1.0, 400.0);
    (0..=steps as u32).map(move |i| (from.0 + dx * i as f32 / steps, from.1 + dy * i as f32 / steps))
}
