//! The frames of links at the start.

use super::linkage::{LinkPoint, Linkage, point_of};
use super::places::{Places, direction};

/// The position of a link.
pub(super) struct Frame {
    pub(super) origin: [f64; 2],
    pub(super) angle: f64,
}

impl Frame {
    /// The frame of a link at the start.
    pub(super) fn at_start(linkage: &Linkage, places: &Places, link: &str) -> Result<Self, String> {
        let points: Vec<LinkPoint> = linkage.points_of(link).iter().map(|point| point_of(link, point)).collect();
        let place = |index: usize| places.place_of(linkage, &points[index]);
        if linkage.corner_count(link) > 0 {
            let [origin, end] = [place(0)?, place(1)?];
            return Ok(Self { origin, angle: direction(origin, end) });
        }
        let own = |index: usize| {
            let LinkPoint { link, point } = &points[index];
            linkage.own_place(link, point).ok_or_else(|| format!("point `{point}` of link `{link}` is a formula"))
        };
        if points.len() < 2 {
            return Err(format!("link `{link}` has one point, so its angle is not seen in the drawing"));
        }
        let [a, b] = [own(0)?, own(1)?];
        let angle = direction(place(0)?, place(1)?) - direction(a, b);
        let [x, y] = place(0)?;
        let (sin, cos) = angle.sin_cos();
        Ok(Self { origin: [x - (a[0] * cos - a[1] * sin), y - (a[0] * sin + a[1] * cos)], angle })
    }

    /// A place in the frame of the link.
    pub(super) fn local(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        let (sin, cos) = self.angle.sin_cos();
        let [x, y] = [x - self.origin[0], y - self.origin[1]];
        [x * cos + y * sin, y * cos - x * sin]
    }
}
