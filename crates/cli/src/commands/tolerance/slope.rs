//! The change of a quantity with a parameter.

/// A derivative, and differences between motions to confirm it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Slope {
    pub(super) derivative: f64,
    /// The difference quotient over the full tolerance.
    pub(super) difference_quotient: f64,
    /// Whether motions at other parameter values confirm the derivative.
    pub(super) is_confirmed: bool,
}

/// The parameter values of the motions, relative to the nominal value, in tolerances. The nominal value lies in the
/// middle.
pub(super) const PLACES: [f64; 4] = [-1.0, -NEAR, NEAR, 1.0];
const NEAR: f64 = 0.125;
/// The relative difference within which a derivative is confirmed.
const MARGIN: f64 = 0.01;

impl Slope {
    /// Creates a slope from a derivative and the values at `PLACES`. Differences below `resolution` are insignificant.
    pub(super) fn new(derivative: f64, values: [f64; 4], tolerance: f64, resolution: f64) -> Self {
        let [first, before, behind, last] = values;
        let difference_quotient = (last - first) / (2.0 * tolerance);
        let near = (behind - before) / (2.0 * NEAR * tolerance);
        // For smooth quantities, each quotient differs from the derivative by a term proportional to the square of its
        // distance.
        let correction = (near - difference_quotient) * NEAR * NEAR / (1.0 - NEAR * NEAR);
        let expected = near + correction;
        let margin = MARGIN * derivative.abs().max(expected.abs());
        let margin = margin + correction.abs() + resolution / (NEAR * tolerance);
        Self { derivative, difference_quotient, is_confirmed: (derivative - expected).abs() <= margin }
    }

    /// The derivative, or the difference quotient if the derivative is not confirmed.
    pub(super) fn value(&self) -> f64 {
        if self.is_confirmed { self.derivative } else { self.difference_quotient }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn slope(derivative: f64, f: impl Fn(f64) -> f64, resolution: f64) -> Slope {
        Slope::new(derivative, PLACES.map(|place| f(0.5 * place)), 0.5, resolution)
    }

    #[test]
    fn derivatives_of_curved_quantities_are_confirmed() {
        for (derivative, f) in [(1.0, f64::exp as fn(f64) -> f64), (1.0, f64::sin), (0.0, f64::cos), (2.0, |x| 2.0 * x)]
        {
            let found = slope(derivative, f, 1e-9);
            assert!(found.is_confirmed && found.value() == derivative, "{found:?}");
            let wrong = slope(derivative + 0.1, f, 1e-9);
            assert!(!wrong.is_confirmed && wrong.value() == f(0.5) - f(-0.5), "{wrong:?}");
        }
    }

    #[test]
    fn differences_take_the_place_of_derivatives_that_do_not_exist() {
        let corner = slope(3.0, |x| if x < 0.0 { x } else { 3.0 * x }, 1e-9);
        assert!(!corner.is_confirmed && corner.value() == 2.0, "{corner:?}");
        let nothing = slope(1e-9, |_| 0.0, 1e-9);
        assert!(nothing.is_confirmed, "{nothing:?}");
        let failed = slope(1.0, |_| f64::NAN, 1e-9);
        assert!(!failed.is_confirmed, "{failed:?}");
    }
}
