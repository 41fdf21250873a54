//! The places of points in the drawing.

use std::collections::BTreeMap;

use serde::Deserialize;

use super::linkage::{GROUND, LinkPoint, Linkage};

/// The largest coordinate of a place, in m.
const MAX_SIZE: f64 = 1e6;

/// The places of points at the start, by their names in the drawing.
#[derive(Debug, Deserialize)]
#[serde(transparent)]
pub(super) struct Places(BTreeMap<String, [f64; 2]>);

impl Places {
    /// The places, if a drawing can show them and these further ones.
    pub(super) fn checked(&self, further: &[[f64; 2]]) -> Result<&Self, String> {
        let is_shown = |[x, y]: &[f64; 2]| x.abs() <= MAX_SIZE && y.abs() <= MAX_SIZE;
        let are_shown = self.0.values().chain(further).all(is_shown);
        are_shown.then_some(self).ok_or_else(|| format!("places lie within {MAX_SIZE} m of the origin"))
    }

    /// The place of a point of a link.
    pub(super) fn place_of(
        &self,
        linkage: &Linkage,
        LinkPoint { link, point }: &LinkPoint,
    ) -> Result<[f64; 2], String> {
        let place = self.0.get(&format!("{link}_{point}")).or_else(|| self.0.get(point)).copied();
        // The drawing leaves out points of the ground that are on no bearing.
        let place = place.or_else(|| if link == GROUND { linkage.own_place(link, point) } else { None });
        place.ok_or_else(|| format!("the page does not show where point `{point}` of link `{link}` is"))
    }

    /// The unit to which lengths are rounded: about 1/10000 of the size of the drawing with these further places.
    pub(super) fn resolution(&self, further: &[[f64; 2]]) -> f64 {
        let spread = |axis: usize| {
            let values = self.0.values().chain(further).map(|place| place[axis]);
            let (low, high) =
                values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)));
            high - low
        };
        let size = spread(0).max(spread(1));
        if size > 0.0 { 10_f64.powf(size.log10().floor() - 4.0) } else { 1e-4 }
    }
}

/// The distance of two places.
pub(super) fn distance([ax, ay]: [f64; 2], [bx, by]: [f64; 2]) -> f64 {
    (bx - ax).hypot(by - ay)
}

/// The angle of the line from a place to another one.
pub(super) fn direction([ax, ay]: [f64; 2], [bx, by]: [f64; 2]) -> f64 {
    (by - ay).atan2(bx - ax)
}
