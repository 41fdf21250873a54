//! The table of integration methods, and the settings of one.

use super::auto::AUTO;
use super::classical::RK4;
use super::dop853::DOP853;
use super::dopri5::DOPRI5;
use super::gauss::GAUSS;
use super::method::Method;
use super::rodas::RODAS;
use super::step_bounds::StepBounds;
use super::step_formula::Task;
use crate::solve::{Projection, ProjectionTolerance};

/// Every method; the first is the default.
pub static METHODS: [&Method; 6] = [RK4, DOPRI5, DOP853, GAUSS, RODAS, AUTO];

/// Finds a method by its name.
pub fn method_named(name: &str) -> Option<&'static Method> {
    METHODS.into_iter().find(|method| method.name == name)
}

/// A method with its settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MethodSettings {
    /// The method.
    pub method: &'static Method,
    /// Largest error of a step, in the unit of each coordinate and rate; methods of a fixed step do not use it.
    pub tolerance: f64,
    /// Metric of the projection after each step.
    pub projection: Projection,
    /// Tolerance of that projection.
    pub projection_tolerance: ProjectionTolerance,
    /// Bounds of the steps that the method chooses.
    pub step_bounds: StepBounds,
}

impl Default for MethodSettings {
    fn default() -> Self {
        Self {
            method: RK4,
            tolerance: 1e-9,
            projection: Projection::default(),
            projection_tolerance: ProjectionTolerance::default(),
            step_bounds: StepBounds::default(),
        }
    }
}

impl MethodSettings {
    /// A method with a tolerance and the default projection.
    pub fn new(method: &'static Method, tolerance: f64) -> Self {
        Self { method, tolerance, ..Self::default() }
    }

    /// The largest error of a step, if the method chooses its steps by it.
    pub fn tolerance(&self) -> Option<f64> {
        self.method.is_adaptive().then_some(self.tolerance)
    }

    /// The task of steps up to a time.
    pub(super) fn task(&self, end_time: f64) -> Task {
        Task {
            tolerance: self.tolerance,
            end_time,
            dense_from: end_time,
            projection: (self.projection, self.projection_tolerance),
            bounds: self.step_bounds,
        }
    }

    /// Whether the generated kernel computes rows: RK4 with its projection.
    pub(crate) fn is_by_kernel(&self) -> bool {
        !self.method.is_adaptive() && self.projection.is_by_kernel(&self.projection_tolerance)
    }
}
