//! Values with their derivatives by parameters.

use qrm_core::Dual;

use super::number::{Derived, Inner, Number, with_part};
use crate::run::{Extremes, rounding};

/// The end of a motion and its outputs, with derivatives by parameters.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sensitivity {
    /// The end time, in s.
    pub end_time: Derivatives,
    /// The coordinates at the end, in rad or m. At an event the derivatives follow the moving end.
    pub q: Vec<Derivatives>,
    /// The rates there.
    pub qd: Vec<Derivatives>,
    /// The outputs, in the order of the description.
    pub outputs: Vec<OutputValues>,
}

/// The values of an output that characterise a motion.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct OutputValues {
    /// The value at the end.
    pub end: Derivatives,
    /// The smallest value, and its time.
    pub minimum: [Derivatives; 2],
    /// The largest value, and its time.
    pub maximum: [Derivatives; 2],
    /// The integral over time.
    pub integral: Derivatives,
}

/// A value with its derivatives by the parameters, in the order of the request.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Derivatives {
    /// The value.
    pub value: f64,
    /// The derivatives of the value by the parameters, in its unit over theirs.
    pub by: Vec<f64>,
    /// The products of its Hessian with the direction: the derivatives of `by` along it; none without a direction.
    pub hessian_vector: Vec<f64>,
    /// Estimated errors of all these; `None` unless they are asked for.
    pub errors: Option<DerivativeErrors>,
}

/// Estimated errors of a value and its derivatives.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DerivativeErrors {
    /// The error of the value.
    pub value: f64,
    /// The errors of its derivatives.
    pub by: Vec<f64>,
    /// The errors of the products with the direction.
    pub hessian_vector: Vec<f64>,
}

/// The results of the motion with derivatives by some of the parameters.
pub(super) struct Motion<T: Inner> {
    /// The number of steps.
    pub(super) steps: u64,
    pub(super) end_time: Derived<T>,
    pub(super) q: Vec<Derived<T>>,
    pub(super) qd: Vec<Derived<T>>,
    pub(super) outputs: Vec<Output<T>>,
}

/// The results for one output.
pub(super) struct Output<T: Inner> {
    pub(super) end: Derived<T>,
    pub(super) extremes: Extremes<Derived<T>>,
    pub(super) integral: Derived<T>,
}

impl Sensitivity {
    /// Adds the derivatives by the next `count` parameters.
    pub(super) fn push<T: Inner>(&mut self, motion: Motion<T>, count: usize) {
        self.q.resize_with(motion.q.len(), Derivatives::default);
        self.qd.resize_with(motion.qd.len(), Derivatives::default);
        self.outputs.resize_with(motion.outputs.len(), OutputValues::default);
        let outputs = motion.outputs.into_iter().flat_map(|output| {
            let Extremes { minimum, maximum, .. } = output.extremes;
            [output.end, minimum.0, minimum.1, maximum.0, maximum.1, output.integral]
        });
        let numbers = std::iter::once(motion.end_time).chain(motion.q).chain(motion.qd).chain(outputs);
        self.all_mut().zip(numbers).for_each(|(all, number)| all.push(&Dual(number), count));
    }

    /// Estimates the errors of the derivatives by those of a more accurate motion, over so many steps: `ratio` is that
    /// of errors to differences.
    pub(super) fn estimate_errors(&mut self, accurate: &mut Self, ratio: f64, steps: u64) {
        for (own, accurate) in self.all_mut().zip(accurate.all_mut()) {
            let error =
                |(own, accurate): (&f64, &f64)| (ratio * (own - accurate).abs()).max(rounding(own.abs(), steps));
            let errors = |own: &[f64], accurate: &[f64]| own.iter().zip(accurate).map(error).collect();
            own.errors = Some(DerivativeErrors {
                value: error((&own.value, &accurate.value)),
                by: errors(&own.by, &accurate.by),
                hessian_vector: errors(&own.hessian_vector, &accurate.hessian_vector),
            });
        }
    }

    /// All values: the end time, coordinates and rates, then each output.
    fn all_mut(&mut self) -> impl Iterator<Item = &mut Derivatives> {
        let state = std::iter::once(&mut self.end_time).chain(&mut self.q).chain(&mut self.qd);
        state.chain(self.outputs.iter_mut().flat_map(OutputValues::all_mut))
    }
}

impl OutputValues {
    fn all_mut(&mut self) -> [&mut Derivatives; 6] {
        let Self { end, minimum: [minimum, at_minimum], maximum: [maximum, at_maximum], integral } = self;
        [end, minimum, at_minimum, maximum, at_maximum, integral]
    }
}

impl Derivatives {
    fn push<T: Inner>(&mut self, number: &Number<T>, count: usize) {
        for part in 0..count {
            let found = with_part(number, part);
            self.value = found.re;
            self.by.push(found.eps1);
            if T::ORDER > 1 {
                self.hessian_vector.push(found.eps1eps2);
            }
        }
    }
}
