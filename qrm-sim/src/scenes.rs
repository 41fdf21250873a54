//! Mechanisms of all sizes behind one interface: what the command works with.

use std::marker::PhantomData;

use qrm_core::{Description, Mechanism, Visitor};

use crate::energy_integral::NoIntegral;
use crate::measure::{Measurement, Patience, StateAt, Trial, exact, measure};
use crate::observer::Observer;
use crate::outcome::{NoStart, Outcome};
use crate::rest::{NoRest, Rest, rest};
#[cfg(feature = "sensitivity")]
use crate::sensitivity::{NoSensitivity, Sensitivity, SensitivityRequest, sensitivity};
use crate::simulate::{Request, simulate};
#[cfg(feature = "stability")]
use crate::spectrum::{Spectrum, spectrum};
#[cfg(feature = "sweep")]
use crate::sweep::{Finished, SweepRequest, Width, sweep};
use crate::turn::{NoTurn, Turn, turn, turns};

/// New values for parameters.
pub type Replace<'a> = &'a dyn Fn(&str) -> Option<f64>;

/// A mechanism whose size is hidden.
pub trait Scene: Sync {
    /// Names, units and meanings.
    fn description(&self) -> Description;

    /// The values of the parameters, some of them replaced, in the order of the description.
    fn parameters(&self, replace: &dyn Fn(&str) -> Option<f64>) -> Vec<f64>;

    /// Runs it with some parameters replaced.
    ///
    /// # Errors
    /// The run could not begin.
    fn simulate(
        &self,
        replace: &dyn Fn(&str) -> Option<f64>,
        request: &Request,
        observer: &mut dyn Observer,
    ) -> Result<Outcome, NoStart>;

    #[cfg(feature = "sensitivity")]
    /// How the motion changes with parameters.
    ///
    /// # Errors
    /// The motion does not come to its end, or is not smooth enough.
    fn sensitivity(&self, replace: Replace, request: &SensitivityRequest) -> Result<Sensitivity, NoSensitivity>;

    #[cfg(feature = "sweep")]
    /// Runs designs that differ in their parameters, and says what became of each, in their order.
    fn sweep(&self, designs: &[Replace], request: &SweepRequest, width: Width) -> Vec<Finished>;

    /// Runs a method to each of the times, again and again.
    ///
    /// # Errors
    /// The run could not begin, or not go to the last time.
    fn measure(
        &self,
        replace: &dyn Fn(&str) -> Option<f64>,
        trial: &Trial,
        times: &[f64],
        patience: Patience,
    ) -> Result<Measurement, NoStart>;

    /// The states at these times from the energy integral, with so many panels in a turn.
    ///
    /// # Errors
    /// The motion is not of the kind that has one.
    fn exact(
        &self,
        replace: &dyn Fn(&str) -> Option<f64>,
        times: &[f64],
        panels: f64,
    ) -> Result<Vec<StateAt>, NoIntegral>;

    #[cfg(feature = "stability")]
    /// The linearized equations at states of time, coordinates and rates; `None` where there are none.
    fn spectra(
        &self,
        replace: &dyn Fn(&str) -> Option<f64>,
        states: &[(f64, Vec<f64>, Vec<f64>)],
    ) -> Vec<Option<Spectrum>>;

    /// Which coordinates are given at the start.
    fn given(&self) -> Vec<bool>;

    /// Turns the driven coordinate once around.
    ///
    /// # Errors
    /// There is nothing to turn.
    fn turn(&self, replace: &dyn Fn(&str) -> Option<f64>) -> Result<Turn, NoTurn>;

    /// Whether the driven coordinate can turn fully.
    fn turns(&self, replace: &dyn Fn(&str) -> Option<f64>) -> bool;

    /// What holds a position at rest.
    ///
    /// # Errors
    /// The position cannot be reached, or not be held.
    fn rest(&self, replace: &dyn Fn(&str) -> Option<f64>, wanted: &[(usize, f64)]) -> Result<Rest, NoRest>;
}

struct Sized<X, const N: usize, const M: usize>(PhantomData<fn() -> X>);

impl<X: Mechanism<N, M>, const N: usize, const M: usize> Scene for Sized<X, N, M> {
    fn description(&self) -> Description {
        X::DESCRIPTION
    }

    fn parameters(&self, replace: &dyn Fn(&str) -> Option<f64>) -> Vec<f64> {
        let mut values = Vec::new();
        X::with_parameters(replace).visit_parameters(&mut |value| values.push(value));
        values
    }

    fn simulate(
        &self,
        replace: &dyn Fn(&str) -> Option<f64>,
        request: &Request,
        observer: &mut dyn Observer,
    ) -> Result<Outcome, NoStart> {
        simulate(&X::with_parameters(replace), request, observer)
    }

    #[cfg(feature = "sensitivity")]
    fn sensitivity(&self, replace: Replace, request: &SensitivityRequest) -> Result<Sensitivity, NoSensitivity> {
        sensitivity::<X, N, M>(replace, request)
    }

    #[cfg(feature = "sweep")]
    fn sweep(&self, designs: &[Replace], request: &SweepRequest, width: Width) -> Vec<Finished> {
        let designs: Vec<X> = designs.iter().map(|replace| X::with_parameters(replace)).collect();
        sweep(&designs, request, width)
    }

    fn measure(
        &self,
        replace: &dyn Fn(&str) -> Option<f64>,
        trial: &Trial,
        times: &[f64],
        patience: Patience,
    ) -> Result<Measurement, NoStart> {
        measure(&X::with_parameters(replace), trial, times, patience)
    }

    fn exact(
        &self,
        replace: &dyn Fn(&str) -> Option<f64>,
        times: &[f64],
        panels: f64,
    ) -> Result<Vec<StateAt>, NoIntegral> {
        exact(&X::with_parameters(replace), times, panels)
    }

    #[cfg(feature = "stability")]
    fn spectra(
        &self,
        replace: &dyn Fn(&str) -> Option<f64>,
        states: &[(f64, Vec<f64>, Vec<f64>)],
    ) -> Vec<Option<Spectrum>> {
        let mechanism = X::with_parameters(replace);
        let of = |(t, q, qd): &(f64, Vec<f64>, Vec<f64>)| {
            let (q, qd) = (q.as_slice().try_into().ok()?, qd.as_slice().try_into().ok()?);
            spectrum(&mechanism, *t, q, qd)
        };
        states.iter().map(of).collect()
    }

    fn given(&self) -> Vec<bool> {
        X::with_parameters(&|_| None).start().given.to_vec()
    }

    fn turn(&self, replace: &dyn Fn(&str) -> Option<f64>) -> Result<Turn, NoTurn> {
        turn(&X::with_parameters(replace))
    }

    fn turns(&self, replace: &dyn Fn(&str) -> Option<f64>) -> bool {
        turns(&X::with_parameters(replace))
    }

    fn rest(&self, replace: &dyn Fn(&str) -> Option<f64>, wanted: &[(usize, f64)]) -> Result<Rest, NoRest> {
        rest(&X::with_parameters(replace), wanted)
    }
}

/// The scenes that a program was built with; fill it as a [`Visitor`].
#[derive(Default)]
pub struct Scenes {
    scenes: Vec<Box<dyn Scene>>,
}

impl Scenes {
    /// The scenes in the order of their names.
    pub fn iter(&self) -> impl Iterator<Item = &dyn Scene> {
        self.scenes.iter().map(AsRef::as_ref)
    }

    /// The scene of this name.
    pub fn find(&self, name: &str) -> Option<&dyn Scene> {
        self.iter().find(|scene| scene.description().name == name)
    }
}

impl Visitor for Scenes {
    fn visit<X: Mechanism<N, M> + Clone + Send + 'static, const N: usize, const M: usize>(&mut self) {
        self.scenes.push(Box::new(Sized::<X, N, M>(PhantomData)));
    }
}
