//! Values with their derivatives by parameters.

use qrm_core::Dual;

use super::number::{Derived, of_part};
use crate::run::Extremes;

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
    /// Its derivatives, in its unit over those of the parameters.
    pub by: Vec<f64>,
}

/// The results of the motion with derivatives by some of the parameters.
pub(super) struct Motion {
    pub(super) end_time: Derived,
    pub(super) q: Vec<Derived>,
    pub(super) qd: Vec<Derived>,
    pub(super) outputs: Vec<Output>,
}

/// The results for one output.
pub(super) struct Output {
    pub(super) end: Derived,
    pub(super) extremes: Extremes<Derived>,
    pub(super) integral: Derived,
}

impl Sensitivity {
    /// Adds the derivatives by the next `count` parameters.
    pub(super) fn push(&mut self, motion: Motion, count: usize) {
        self.q.resize_with(motion.q.len(), Derivatives::default);
        self.qd.resize_with(motion.qd.len(), Derivatives::default);
        self.outputs.resize_with(motion.outputs.len(), OutputValues::default);
        self.end_time.push(motion.end_time, count);
        let numbers = motion.q.into_iter().chain(motion.qd);
        self.q.iter_mut().chain(&mut self.qd).zip(numbers).for_each(|(all, number)| all.push(number, count));
        for (all, output) in self.outputs.iter_mut().zip(motion.outputs) {
            all.end.push(output.end, count);
            all.integral.push(output.integral, count);
            let Extremes { minimum, maximum } = output.extremes;
            for ([value, time], found) in [(&mut all.minimum, minimum), (&mut all.maximum, maximum)] {
                value.push(found.0, count);
                time.push(found.1, count);
            }
        }
    }
}

impl Derivatives {
    fn push(&mut self, number: Derived, count: usize) {
        self.value = number.re;
        self.by.extend((0..count).map(|place| of_part(&Dual(number), place).eps));
    }
}
