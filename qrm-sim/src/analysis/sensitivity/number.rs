//! Numbers with their derivatives by several parameters, and the derivatives of those along a direction.

use num_dual::{Derivative, Dual64, DualSVec, HyperDual64};
use qrm_core::{DualKind, Scalar};

use crate::differentiated::Differentiated;
pub(super) use crate::differentiated::{PARTS, derivative, differentiated};

/// A value with its derivatives by parameters.
pub(super) type Derived<T> = DualSVec<T, PARTS>;

/// A value with its derivatives by parameters, as the scalar that a tape is evaluated on.
pub(super) type Number<T> = Differentiated<T>;

/// The type of a value or a derivative: a double, or a double with its derivative along a direction of the parameters.
pub(super) trait Inner: DualKind {
    /// The order of the highest derivative of a number.
    const ORDER: usize;

    /// The value with its derivative along the direction.
    fn new(value: f64, along: f64) -> Self;

    /// The derivative along the direction; zero for a plain double.
    fn along(&self) -> f64;
}

impl Inner for f64 {
    const ORDER: usize = 1;

    fn new(value: f64, _: f64) -> Self {
        value
    }

    fn along(&self) -> f64 {
        0.0
    }
}

impl Inner for Dual64 {
    const ORDER: usize = 2;

    fn new(value: f64, along: f64) -> Self {
        Self::new(value, along)
    }

    fn along(&self) -> f64 {
        self.eps
    }
}

/// The place of a derivative in a number.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// The parameter; `None` for the value.
    part: Option<usize>,
    /// Whether it is the derivative along the direction.
    is_along: bool,
}

impl Place {
    /// The derivatives by the first `parts` parameters, and those along the direction.
    pub(super) fn all<T: Inner>(parts: usize) -> impl Iterator<Item = Self> {
        let with_direction = |part| [false, true].map(|is_along| Self { part, is_along });
        let places = std::iter::once(None).chain((0..parts).map(Some)).flat_map(with_direction);
        places.skip(1).filter(|place| !place.is_along || T::ORDER > 1)
    }

    /// The derivative of a number.
    pub(super) fn get<T: Inner>(self, number: &Number<T>) -> f64 {
        let inner = self.part.map_or(number.0.re, |part| derivative(number, part));
        if self.is_along { inner.along() } else { inner.re() }
    }

    /// Adds to the derivative of a number.
    pub(super) fn add<T: Inner>(self, number: &mut Number<T>, change: f64) {
        let change = if self.is_along { T::new(0.0, change) } else { T::from(change) };
        match self.part {
            None => number.0.re += change,
            Some(part) => {
                let mut all = derivatives(number);
                all[part] += change;
                number.0.eps = Derivative::some(all.into());
            }
        }
    }
}

/// The derivatives of a number by all parameters.
fn derivatives<T: Inner>(number: &Number<T>) -> [T; PARTS] {
    std::array::from_fn(|part| derivative(number, part))
}

/// A number with its derivatives by one of the parameters and along the direction.
pub(super) fn with_part<T: Inner>(number: &Number<T>, part: usize) -> HyperDual64 {
    let (value, by) = (number.0.re, derivative(number, part));
    HyperDual64::new(value.re(), by.re(), value.along(), by.along())
}

/// The values of numbers.
pub(super) fn values<T: Inner>(numbers: &[Number<T>]) -> Vec<f64> {
    numbers.iter().map(|number| number.to_f64()).collect()
}

/// Numbers of these values, without derivatives.
pub(super) fn constants<T: Inner>(values: &[f64]) -> Vec<Number<T>> {
    values.iter().map(|value| Number::from_f64(*value)).collect()
}

/// Whether all derivatives are finite.
pub(super) fn has_derivatives<T: Inner>(number: &Number<T>) -> bool {
    Place::all::<T>(PARTS).all(|place| place.get(number).is_finite())
}

/// Completes the solution of equations by its derivatives, where its values are known.
///
/// `open` is the right side of the equations less the left side, and `solve` makes a right side the solution of the
/// equations of the values, linearized. A pass of this simplified Newton iteration gives the derivatives of one order
/// from those below it: what the matrix lacks are derivatives, and their products vanish beyond the highest order.
///
/// # Errors
/// An equation could not be evaluated or solved.
pub(super) fn complete<T: Inner, E>(
    x: &mut [Number<T>],
    parts: usize,
    mut open: impl FnMut(&[Number<T>]) -> Result<Vec<Number<T>>, E>,
    mut solve: impl FnMut(Vec<f64>) -> Result<Vec<f64>, E>,
) -> Result<(), E> {
    for _ in 0..T::ORDER {
        let right = open(x)?;
        for place in Place::all::<T>(parts) {
            let change = solve(right.iter().map(|number| place.get(number)).collect())?;
            x.iter_mut().zip(change).for_each(|(x, change)| place.add(x, change));
        }
    }
    Ok(())
}
