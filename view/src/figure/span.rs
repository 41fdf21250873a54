//! From where to where an axis has to reach.

use super::{Curve, Panel, Scale};

/// The smallest and the largest of some values.
pub(super) fn of(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.fold(None, |found: Option<(f64, f64)>, v| match found {
        Some((low, high)) => Some((low.min(v), high.max(v))),
        None => Some((v, v)),
    })
}

/// What the ordinate of a panel has to show; nothing if there is nothing to show.
pub(super) fn of_panel(panel: &Panel) -> Option<(f64, f64)> {
    of(panel.curves.iter().flat_map(values).filter(|v| is_shown(panel.scale, *v)))
}

/// Whether the scale has a place for a value.
pub(super) fn is_shown(scale: Scale, value: f64) -> bool {
    scale == Scale::Linear || value > 0.0
}

fn values(curve: &Curve) -> impl Iterator<Item = f64> {
    let marked = curve.extremes.iter().flat_map(|e| [e.minimum.1, e.maximum.1]);
    curve.points.iter().map(|point| point.1).chain(marked)
}

/// A range wide enough to be divided: what is constant gets room on both sides, and so does what differs by rounding
/// errors only.
pub(super) fn widened((low, high): (f64, f64)) -> (f64, f64) {
    let size = low.abs().max(high.abs());
    let wanted = match high - low {
        _ if size == 0.0 => 2.0,
        0.0 => 0.2 * size,
        _ => 1e-12 * size,
    };
    // Below this the step of the ticks has no reciprocal.
    let wanted = wanted.max(1e-300);
    if high - low >= wanted {
        return (low, high);
    }
    let middle = 0.5 * low + 0.5 * high;
    (middle - 0.5 * wanted, middle + 0.5 * wanted)
}

/// A range with room for `room` of `length` pixels at each end.
pub(super) fn padded((low, high): (f64, f64), room: f64, length: f64) -> (f64, f64) {
    let pad = (high - low) * room / (length - 2.0 * room).max(1.0);
    (low - pad, high + pad)
}
