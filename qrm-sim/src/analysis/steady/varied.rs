//! A parameter that is varied.

use std::ops::Deref;

use qrm_core::{Mechanism, Model, ParameterOverrides};

/// A parameter that is an unknown.
#[derive(Clone, Copy)]
pub(super) struct Varied<'a> {
    pub(super) model: &'a Model,
    /// The values that replace those of the scene.
    pub(super) replace: ParameterOverrides<'a>,
    /// Its number.
    pub(super) parameter: usize,
    /// Its size: the range of its values.
    pub(super) size: f64,
    /// The period at a value of the parameter, where formulae depend on time; `None` if the motion has its own.
    pub(super) period: Option<&'a dyn Fn(f64) -> Option<f64>>,
}

/// The part of the range over which differences of the period are taken. Newton's method needs few digits of them.
const SHIFT: f64 = 1e-5;

impl Varied<'_> {
    /// The mechanism with a value of the parameter; the parameters that the scene computes from it follow.
    pub(super) fn mechanism(&self, value: f64) -> Box<dyn Mechanism> {
        let own = self.model.description.parameters[self.parameter].name;
        self.model.mechanism(&|name| if name == own { Some(value) } else { (self.replace)(name) })
    }

    /// The derivative of the period by the parameter; zero if the motion has its own.
    pub(super) fn period_by(&self, value: f64) -> f64 {
        let Some(period) = self.period else { return 0.0 };
        let shift = SHIFT * self.size;
        match [period(value - shift), period(value), period(value + shift)] {
            [Some(low), _, Some(high)] => (high - low) / (2.0 * shift),
            [Some(low), Some(at), None] => (at - low) / shift,
            [None, Some(at), Some(high)] => (high - at) / shift,
            _ => 0.0,
        }
    }
}

/// A mechanism, owned or borrowed.
pub(super) enum OwnedOr<'a> {
    Owned(Box<dyn Mechanism>),
    Borrowed(&'a dyn Mechanism),
}

impl<'a> Deref for OwnedOr<'a> {
    type Target = dyn Mechanism + 'a;

    fn deref(&self) -> &Self::Target {
        match self {
            Self::Owned(mechanism) => &**mechanism,
            Self::Borrowed(mechanism) => *mechanism,
        }
    }
}
