//! The ranges of axes.

use super::axis::Axis;
use super::{Abscissa, Curve, Figure, NoPicture, Panel, Scale};

/// The abscissa of all panels.
pub(super) fn time_axis(figure: &Figure) -> Result<Axis, NoPicture> {
    let curves = || figure.panels.iter().flat_map(|panel| &panel.curves);
    let is_finite = |(t, v): &(f64, f64)| t.is_finite() && v.is_finite();
    for curve in curves() {
        let marked = curve.extremes.iter().flat_map(|e| [e.minimum, e.maximum]);
        if !curve.points.iter().copied().chain(marked).all(|point| is_finite(&point)) {
            return Err(NoPicture::NotFinite(curve.name.clone()));
        }
    }
    let Abscissa { quantity, scale, .. } = &figure.abscissa;
    let times = curves().flat_map(|curve| curve.points.iter().map(|point| point.0));
    let times = range(times.filter(|t| is_shown(*scale, *t))).ok_or(NoPicture::Empty)?;
    if *scale == Scale::Logarithmic {
        return Ok(Axis::logarithmic(times.0.log10(), times.1.log10(), 9));
    }
    let (first, last) = widened(times);
    if !(last - first).is_finite() {
        return Err(NoPicture::TooFarApart(quantity.clone()));
    }
    Ok(Axis::linear(first, last, 9))
}

/// The ordinate of a panel that is about `height` pixels high; `None` if the panel has no value to show.
pub(super) fn value_axis(panel: &Panel, height: f64) -> Result<Option<Axis>, NoPicture> {
    // A floor gets a decade below it, for its text.
    let below = if panel.scale == Scale::Logarithmic { 0.1 } else { 1.0 };
    let floor = panel.floor.iter().map(|(value, _)| below * *value);
    let shown = panel.curves.iter().flat_map(values).chain(floor).filter(|value| is_shown(panel.scale, *value));
    let Some((low, high)) = range(shown) else { return Ok(None) };
    // A line of text fits above and below the curves.
    let room = if panel.curves.iter().any(|curve| curve.extremes.is_some()) { 24.0 } else { 6.0 };
    if panel.scale == Scale::Logarithmic {
        let (low, high) = padded((low.log10(), high.log10()), room - 6.0, height);
        return Ok(Some(Axis::logarithmic(low, high, (height / 24.0) as usize)));
    }
    let (low, high) = padded(widened((low, high)), room, height);
    if !(high - low).is_finite() {
        return Err(NoPicture::TooFarApart(panel.quantity.clone()));
    }
    Ok(Some(Axis::linear(low, high, (height / 38.0) as usize)))
}

/// Widens two axes on areas of these sizes to equal scales and, if `with_zero`, to contain zero.
pub(super) fn equalize(axes: [&mut Axis; 2], sizes: [f64; 2], with_zero: bool) {
    let wanted = |(low, high): (f64, f64)| if with_zero { (low.min(0.0), high.max(0.0)) } else { (low, high) };
    let spans = [0, 1].map(|i| padded(wanted(axes[i].span()), 0.04, 1.0));
    let per_pixel = (0..2).map(|i| (spans[i].1 - spans[i].0) / sizes[i]).fold(0.0, f64::max);
    for ((axis, (low, high)), (size, room)) in axes.into_iter().zip(spans).zip(sizes.into_iter().zip([80.0, 38.0])) {
        let (middle, half) = (0.5 * low + 0.5 * high, 0.5 * per_pixel * size);
        *axis = Axis::linear(middle - half, middle + half, (size / room) as usize);
    }
}

/// The smallest and the largest of some values.
fn range(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    values.fold(None, |found: Option<(f64, f64)>, v| match found {
        Some((low, high)) => Some((low.min(v), high.max(v))),
        None => Some((v, v)),
    })
}

/// Whether a value can be shown on a scale.
pub(super) fn is_shown(scale: Scale, value: f64) -> bool {
    scale == Scale::Linear || value > 0.0
}

fn values(curve: &Curve) -> impl Iterator<Item = f64> {
    let marked = curve.extremes.iter().flat_map(|e| [e.minimum.1, e.maximum.1]);
    curve.points.iter().map(|point| point.1).chain(marked)
}

/// Widens a range that is too narrow to be divided: constant values get room on both sides, and so do values that
/// differ only by rounding errors.
fn widened((low, high): (f64, f64)) -> (f64, f64) {
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

/// Extends a range by `room` of `length` pixels at each end.
fn padded((low, high): (f64, f64), room: f64, length: f64) -> (f64, f64) {
    let pad = (high - low) * room / (length - 2.0 * room).max(1.0);
    (low - pad, high + pad)
}
