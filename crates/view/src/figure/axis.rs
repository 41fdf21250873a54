//! Axes: their ranges, ticks and labels.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

use super::number::{decimal, exact, magnitude, power_of_ten, ten_to};

/// The number of steps of the last differing digit above which the ticks have a common offset.
const MOST_STEPS: f64 = 99_999.0;

/// An axis with its ticks. All choices of plotters are made here, since plotters loops or panics on some ranges.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    low: f64,
    high: f64,
    is_logarithmic: bool,
    ticks: Vec<(f64, String)>,
    light: Vec<f64>,
    /// The offset that is subtracted from the tick labels, as text to append to the quantity; empty if there is none.
    offset: String,
    /// The power of ten by which the labels are divided.
    factor: i32,
}

impl Axis {
    /// Creates an axis from `low` to `high`, which must differ by a finite number, with about `wanted` ticks.
    pub(super) fn linear(low: f64, high: f64, wanted: usize) -> Self {
        let raw = (high - low) / wanted.max(1) as f64;
        let mut exponent = magnitude(raw);
        let mut digit: i128 = 1;
        while (digit as f64) * ten_to(exponent) < raw * 0.7 {
            (digit, exponent) = match digit {
                1 => (2, exponent),
                2 => (5, exponent),
                _ => (1, exponent + 1),
            };
        }
        let step = digit as f64 * ten_to(exponent);
        let (first, last) = ((low / step).ceil(), (high / step).floor());
        let base = if first.abs().max(last.abs()) > MOST_STEPS {
            ((0.5 * (first + last)) / 10.0).round() as i128 * 10
        } else {
            0
        };
        let (first, last) = (first as i128, last as i128);
        let largest = (first - base).abs().max((last - base).abs()).max(1) * digit;
        let top = largest.ilog10() as i32 + exponent;
        let factor = if (-2..6).contains(&top) { 0 } else { top.div_euclid(3) * 3 };
        let decimals = (factor - exponent).max(0) as usize;
        let tick = |k: i128| {
            let value = if step < 1.0 { k as f64 / (1.0 / step) } else { k as f64 * step };
            let value = if value.is_finite() { value } else { k as f64 * step };
            (value, decimal((k - base) * digit, exponent - factor, decimals))
        };
        let offset = match base {
            0 => String::new(),
            _ if base < 0 => format!(" + {}", exact(-base * digit, exponent)),
            _ => format!(" − {}", exact(base * digit, exponent)),
        };
        let ticks = (first..=last).map(tick).collect();
        Self { low, high, is_logarithmic: false, ticks, light: Vec::new(), offset, factor }
    }

    /// The ends of the axis.
    pub(super) fn span(&self) -> (f64, f64) {
        (self.low, self.high)
    }

    /// Creates an axis of whole decades that contains 10^`low` to 10^`high`, with at most about `wanted` ticks.
    pub(super) fn logarithmic(low: f64, high: f64, wanted: usize) -> Self {
        // At least one decade, within the range of doubles.
        let first = (low.floor() as i32).clamp(-323, 307);
        let last = (high.ceil() as i32).clamp(first + 1, 308);
        let decades = last - first;
        let sizes = [1, 2, 3, 5, 10, 20, 50, 100];
        let size = sizes.into_iter().find(|s| decades / s < wanted.max(2) as i32).unwrap_or(200);
        let label = |e: i32| if e == 0 { "1".to_owned() } else { power_of_ten(e) };
        let ticks = (first..=last).filter(|e| e.rem_euclid(size) == 0).map(|e| (ten_to(e), label(e))).collect();
        let light = match (decades, size) {
            (..=4, _) => (first..last).flat_map(|e| (2..10).map(move |d| f64::from(d) * ten_to(e))).collect(),
            (..=40, 2..) => (first..=last).filter(|e| e.rem_euclid(size) != 0).map(ten_to).collect(),
            _ => Vec::new(),
        };
        let (low, high) = (ten_to(first), ten_to(last));
        Self { low, high, is_logarithmic: true, ticks, light, offset: String::new(), factor: 0 }
    }

    /// The title of the axis: `force (×10³ N)`.
    pub(super) fn description(&self, quantity: &str, unit: &str) -> String {
        let factor = if self.factor == 0 { String::new() } else { format!("×{}", power_of_ten(self.factor)) };
        let gap = if factor.is_empty() || unit.is_empty() { "" } else { " " };
        let inside = format!("{factor}{gap}{unit}");
        let inside = if inside.is_empty() { inside } else { format!(" ({inside})") };
        format!("{quantity}{}{inside}", self.offset)
    }

    /// The labels of the ticks.
    pub(super) fn labels(&self) -> impl Iterator<Item = &str> {
        self.ticks.iter().map(|tick| tick.1.as_str())
    }

    /// Whether zero lies strictly inside.
    pub(super) fn has_zero_inside(&self) -> bool {
        !self.is_logarithmic && self.low < 0.0 && self.high > 0.0
    }

    /// The position of a value along the axis, from 0 to 1.
    fn fraction(&self, value: f64) -> f64 {
        let fraction = if self.is_logarithmic {
            (value.log10() - self.low.log10()) / (self.high.log10() - self.low.log10())
        } else {
            (value - self.low) / (self.high - self.low)
        };
        fraction.clamp(0.0, 1.0)
    }
}

impl Ranged for Axis {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (start, end): (i32, i32)) -> i32 {
        start + (f64::from(end - start) * self.fraction(*value)).round() as i32
    }

    fn key_points<H: KeyPointHint>(&self, hint: H) -> Vec<f64> {
        if hint.weight().allow_light_points() {
            self.light.clone()
        } else {
            self.ticks.iter().map(|tick| tick.0).collect()
        }
    }

    fn range(&self) -> Range<f64> {
        self.low..self.high
    }
}

impl ValueFormatter<f64> for Axis {
    fn format_ext(&self, value: &f64) -> String {
        self.ticks.iter().find(|tick| tick.0 == *value).map_or(String::new(), |tick| tick.1.clone())
    }
}
