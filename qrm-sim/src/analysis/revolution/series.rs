//! The values of a quantity over a revolution, and its turning points.

/// The values of a quantity over the revolution, or between the limit positions.
#[derive(Clone, Debug, Default)]
pub struct Series {
    /// Value at the beginning and at the end.
    pub ends: [f64; 2],
    /// The turning points, in the order of the turn.
    pub vertices: Vec<Vertex>,
    /// The smallest value of the quantity and its position, at a vertex or an end; infinite if unbounded.
    pub smallest: (f64, f64),
    /// The largest value of the quantity and its position, likewise.
    pub largest: (f64, f64),
}

/// A turning point of a quantity.
#[derive(Clone, Copy, Debug)]
pub struct Vertex {
    /// The driven coordinate.
    pub angle: f64,
    /// The value.
    pub value: f64,
}

impl Series {
    /// Whether the last value equals the first one, up to rounding.
    pub fn is_periodic(&self) -> bool {
        let [first, last] = self.ends;
        (last - first).abs() <= 1e-9 * (self.largest.0 - self.smallest.0)
    }
}

/// The vertex of the parabola through three points if it lies between them, otherwise the middle point.
pub(super) fn parabola([a0, a, a1]: [f64; 3], [v0, v, v1]: [f64; 3]) -> Vertex {
    let [left, right] = [(v0 - v) / (a0 - a), (v1 - v) / (a1 - a)];
    let curvature = (right - left) / (a1 - a0);
    let slope = left - curvature * (a0 - a);
    let shift = -0.5 * slope / curvature;
    if (a0 - a).min(a1 - a) < shift && shift < (a0 - a).max(a1 - a) {
        Vertex { angle: a + shift, value: v + 0.5 * slope * shift }
    } else {
        Vertex { angle: a, value: v }
    }
}
