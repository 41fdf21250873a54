//! The position of the drawing in the picture.

use crate::motion::{Motion, Node, Shape};

use super::track::{Moment, angle, value};

/// The length of the longest arrow, relative to the drawing.
const LONGEST: f64 = 0.28;
/// The margin around the drawing: joints, bearings and labels extend beyond the nodes.
const MARGIN: f64 = 44.0;
/// The room for the title and the time at the top, and for the scale of the arrows at the bottom.
const HEAD: f64 = 46.0;
const FOOT: f64 = 12.0;

/// A position in the picture.
pub(super) type Point = (f32, f32);

/// The mapping of the drawing into the picture.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Stage {
    pub(super) width: u32,
    pub(super) height: u32,
    /// The largest force in N; zero if there is none.
    pub(super) largest: f64,
    /// The scale of arrows, in m per N.
    arrow: f64,
    /// The scale of lengths, in pixels per m.
    scale: f64,
    /// The point of the motion at the centre of the stage in m, and its position in the picture in pixels.
    middle: (f64, f64),
    centre: (f64, f64),
}

impl Stage {
    /// Fits everything into the picture; `None` if the range is too large.
    pub(super) fn new(motion: &Motion) -> Option<Self> {
        let forces = motion
            .arrows
            .iter()
            .flat_map(|arrow| frames(motion).map(|moment| value(&arrow.x, moment).hypot(value(&arrow.y, moment))));
        let largest = forces.fold(0.0, f64::max);
        let bodies = Extent::around(drawn_positions(motion))?;
        // If nothing has an extent, any scale will do.
        let size = bodies.width().max(bodies.height());
        let size = if size > 0.0 { size } else { 1.0 };
        let arrow = if largest > 0.0 { LONGEST * size / largest } else { 0.0 };
        let tips = motion.arrows.iter().flat_map(|a| {
            let node = &motion.nodes[a.node];
            frames(motion).map(move |moment| {
                let (x, y) = place(node, moment);
                (x + arrow * value(&a.x, moment), y + arrow * value(&a.y, moment))
            })
        });
        let all = Extent::around(drawn_positions(motion).chain(tips))?;
        let is_finite = [largest, all.width(), all.height(), arrow].into_iter().all(f64::is_finite);
        is_finite.then(|| Self::fitted(&all, size, largest, arrow)).filter(|stage| stage.scale.is_finite())
    }

    fn fitted(all: &Extent, size: f64, largest: f64, arrow: f64) -> Self {
        // Thin drawings get margins, and rounding errors of large coordinates are ignored.
        let far = all.low.0.abs().max(all.high.0.abs()).max(all.low.1.abs()).max(all.high.1.abs());
        let least = (0.05 * size).max(1e-9 * far);
        let (width, height) = (all.width().max(least), all.height().max(least));
        let free = (640.0 - 2.0 * MARGIN, 480.0 - 2.0 * MARGIN - HEAD - FOOT);
        let scale = (free.0 / width).min(free.1 / height);
        let wide = (width * scale + 2.0 * MARGIN).clamp(400.0, 640.0).round();
        let high = (height * scale + 2.0 * MARGIN + HEAD + FOOT).clamp(240.0, 480.0).round();
        let middle = (0.5 * all.low.0 + 0.5 * all.high.0, 0.5 * all.low.1 + 0.5 * all.high.1);
        let centre = (0.5 * wide, HEAD + 0.5 * (high - HEAD - FOOT));
        Self { width: wide as u32, height: high as u32, largest, arrow, scale, middle, centre }
    }

    /// The position of a node in the picture.
    pub(super) fn to_picture(&self, node: &Node, moment: Moment) -> Point {
        self.pixel(place(node, moment))
    }

    fn pixel(&self, (x, y): (f64, f64)) -> Point {
        let x = self.centre.0 + self.scale * (x - self.middle.0);
        let y = self.centre.1 - self.scale * (y - self.middle.1);
        (x as f32, y as f32)
    }

    /// The picture position of a point in a frame at a node, turned by an angle.
    pub(super) fn to_picture_in_frame(&self, node: &Node, angle: f64, at: [f64; 2], moment: Moment) -> Point {
        self.pixel(moved(place(node, moment), angle, at))
    }

    /// A length in the picture.
    pub(super) fn length(&self, metres: f64) -> f32 {
        (self.scale * metres) as f32
    }

    /// A force as a vector in the picture.
    pub(super) fn arrow(&self, (x, y): (f64, f64)) -> Point {
        let pixels = self.arrow * self.scale;
        ((pixels * x) as f32, (-pixels * y) as f32)
    }
}

fn frames(motion: &Motion) -> impl Iterator<Item = Moment> + Clone {
    (0..motion.times.len()).map(Moment::from_frame)
}

fn place(node: &Node, moment: Moment) -> (f64, f64) {
    (value(&node.x, moment), value(&node.y, moment))
}

/// The positions of everything that is drawn.
fn drawn_positions(motion: &Motion) -> impl Iterator<Item = (f64, f64)> {
    let of_arrows = motion.arrows.iter().map(|arrow| &motion.nodes[arrow.node]);
    let visible = motion.nodes.iter().filter(|node| node.is_traced || !node.name.is_empty());
    let nodes = of_arrows.chain(visible).flat_map(|node| frames(motion).map(|moment| place(node, moment)));
    motion.shapes.iter().flat_map(|shape| reached_by(motion, shape)).chain(nodes)
}

/// The extreme positions of a shape.
fn reached_by<'m>(motion: &'m Motion, shape: &'m Shape) -> impl Iterator<Item = (f64, f64)> + 'm {
    let discs = shape.nodes().iter().zip(shape.radii()).flat_map(move |(node, radius)| {
        let corners = move |(x, y): (f64, f64)| [(x - radius, y - radius), (x + radius, y + radius)];
        frames(motion).flat_map(move |moment| corners(place(&motion.nodes[*node], moment)))
    });
    let ends = shape.ends().zip(shape.angle()).into_iter().flat_map(move |(ends, track)| {
        let node = &motion.nodes[shape.nodes()[0]];
        frames(motion).flat_map(move |moment| ends.map(|end| moved(place(node, moment), angle(track, moment), end)))
    });
    discs.chain(ends)
}

/// The distance of two points, and a function from positions along their line and to its right to the picture; `None`
/// for points that coincide.
pub(super) fn frame_along((x, y): Point, (to_x, to_y): Point) -> Option<(f32, impl Fn(f32, f32) -> Point)> {
    let length = (to_x - x).hypot(to_y - y);
    let (ux, uy) = ((to_x - x) / length, (to_y - y) / length);
    let at = move |along: f32, aside: f32| (x + along * ux - aside * uy, y + along * uy + aside * ux);
    (length > 1.0).then_some((length, at))
}

/// A position in a frame with this origin and angle.
fn moved((x, y): (f64, f64), angle: f64, [along, across]: [f64; 2]) -> (f64, f64) {
    let (sin, cos) = angle.sin_cos();
    (x + along * cos - across * sin, y + along * sin + across * cos)
}

/// A rectangle aligned with the axes.
struct Extent {
    low: (f64, f64),
    high: (f64, f64),
}

impl Extent {
    /// Encloses positions; `None` if the extent is not finite, a single point if there are none.
    fn around(places: impl Iterator<Item = (f64, f64)>) -> Option<Self> {
        let grown = |found: Option<Self>, (x, y): (f64, f64)| match found {
            None => Some(Self { low: (x, y), high: (x, y) }),
            Some(b) => Some(Self { low: (b.low.0.min(x), b.low.1.min(y)), high: (b.high.0.max(x), b.high.1.max(y)) }),
        };
        let all = places.fold(None, grown).unwrap_or(Self { low: (0.0, 0.0), high: (0.0, 0.0) });
        (all.width().is_finite() && all.height().is_finite()).then_some(all)
    }

    fn width(&self) -> f64 {
        self.high.0 - self.low.0
    }

    fn height(&self) -> f64 {
        self.high.1 - self.low.1
    }
}
