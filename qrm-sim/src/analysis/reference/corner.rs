//! Corners and jumps of a motion, to all digits: the zeros of switching functions on the smooth continuation.

use qrm_core::{Scalar, Tape};

use super::{At, Motion};
use crate::integrate::StepError;
use crate::solve::{Number, PreciseEquations};

/// The fraction of a step after which the signs of switching functions are taken: behind the corner at its beginning.
const SIGN_OFFSET: f64 = 1e-9;
/// The number of points at which a step is inspected by its cubic.
const INSPECTION_POINTS: i32 = 32;
/// The largest number of steps to a corner, and the final size of the bracket or the value.
const MOST: usize = 100;
const LEFT: f64 = 1e-29;

impl PreciseEquations<'_> {
    /// The smooth continuation of the equations from a state.
    pub(super) fn smooth_from(&mut self, at: &At) -> Tape {
        let (t, y) = behind(at);
        let (q, qd) = y.split_at(y.len() / 2);
        self.evaluator.with_signs_of(t, q, qd)
    }

    /// The signs of the switching functions from a state.
    pub(super) fn signs_from(&mut self, at: &At) -> Vec<f64> {
        let (t, y) = behind(at);
        self.switching_functions(t, &y).iter().map(|value| value.to_f64().signum()).collect()
    }

    fn switching_functions(&mut self, t: Number, y: &[Number]) -> Vec<Number> {
        let mut values = vec![Number::zero(); self.evaluator.tape().switching_functions.results.len()];
        let (q, qd) = y.split_at(y.len() / 2);
        self.evaluator.switching_functions(t, q, qd, &mut values);
        values
    }
}

/// The state a little later, along the tangent.
fn behind(at: &At) -> (Number, Vec<Number>) {
    let h = Number::from(SIGN_OFFSET * at.h);
    (at.t + h, at.y.iter().zip(&at.slope).map(|(y, slope)| *y + h * *slope).collect())
}

impl Motion<'_> {
    /// Finds the first corner in a step from here to `next`; `None` if there is none.
    ///
    /// # Errors
    /// A step to it could not be made.
    pub(super) fn first_corner(
        &mut self,
        h: Number,
        next: &[Number],
    ) -> Result<Option<(Number, Vec<Number>)>, StepError> {
        if self.signs.is_empty() {
            return Ok(None);
        }
        let mut end_slope = next.to_vec();
        self.equations.slope(self.at.t + h, next, &mut end_slope)?;
        let place = |point: i32| Number::from(f64::from(point) / f64::from(INSPECTION_POINTS));
        for point in 1..=INSPECTION_POINTS {
            let (part, is_end) = (place(point), point == INSPECTION_POINTS);
            let y = if is_end { next.to_vec() } else { self.cubic(part, h, next, &end_slope) };
            if self.least(self.at.t + part * h, &y) > Number::zero() {
                continue;
            }
            // The cubic only tells where to search.
            let mut high = (part, if is_end { y } else { self.extrapolated(part * h)?.0 });
            let mut value_high = self.least(self.at.t + part * h, &high.1);
            if value_high > Number::zero() {
                continue;
            }
            for before in (0..point).rev() {
                let low = place(before);
                let y = if before == 0 { self.at.y.clone() } else { self.extrapolated(low * h)?.0 };
                let value = self.least(self.at.t + low * h, &y);
                if value > Number::zero() || before == 0 {
                    return self.zero_between([low, high.0], [value, value_high], h, high.1).map(Some);
                }
                (high, value_high) = ((low, y), value);
            }
        }
        Ok(None)
    }

    /// Finds the zero between two fractions of a step by the Illinois method, and the state there.
    ///
    /// # Errors
    /// A step to it could not be made.
    fn zero_between(
        &mut self,
        [mut low, mut high]: [Number; 2],
        [mut value_low, mut value_high]: [Number; 2],
        h: Number,
        mut state: Vec<Number>,
    ) -> Result<(Number, Vec<Number>), StepError> {
        let size = value_high.to_f64().abs();
        let half = Number::from(0.5);
        let mut found = size;
        let mut was_low = None;
        for _ in 0..MOST {
            if found <= LEFT * size || (high - low).to_f64() <= LEFT || self.equations.is_spent() {
                break;
            }
            let secant = low + (high - low) * value_low / (value_low - value_high);
            let part = if secant > low && secant < high { secant } else { low + (high - low) * half };
            let y = self.extrapolated(part * h)?.0;
            let value = self.least(self.at.t + part * h, &y);
            let is_low = value > Number::zero();
            let is_twice = was_low.replace(is_low) == Some(is_low);
            if is_low {
                (low, value_low) = (part, value);
                value_high = if is_twice { value_high * half } else { value_high };
            } else {
                (high, value_high, state) = (part, value, y);
                found = value.to_f64().abs();
                value_low = if is_twice { value_low * half } else { value_low };
            }
        }
        Ok((self.at.t + high * h, state))
    }

    /// The smallest value of the switching functions, each multiplied by its sign in this part of the motion.
    fn least(&mut self, t: Number, y: &[Number]) -> Number {
        let values = self.equations.switching_functions(t, y);
        let signed = values.iter().zip(&self.signs).map(|(value, sign)| *value * Number::from(*sign));
        signed.fold(Number::from(f64::INFINITY), |least, value| if value < least { value } else { least })
    }

    /// The cubic through the ends of a step.
    fn cubic(&self, part: Number, h: Number, next: &[Number], end_slope: &[Number]) -> Vec<Number> {
        let one = Number::from(1.0);
        let (rest, two) = (one - part, Number::from(2.0));
        let weights = [
            (one + two * part) * rest * rest,
            part * part * (Number::from(3.0) - two * part),
            h * part * rest * rest,
            -(h * part * part * rest),
        ];
        let ends = self.at.y.iter().zip(next).zip(self.at.slope.iter().zip(end_slope));
        ends.map(|((a, b), (va, vb))| weights[0] * *a + weights[1] * *b + weights[2] * *va + weights[3] * *vb).collect()
    }
}
