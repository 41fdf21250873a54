//! Mechanisms of all sizes behind one interface: what the command works with.

use std::marker::PhantomData;

use qrm_mechanism::{Description, Mechanism, Visitor};

use crate::observer::Observer;
use crate::outcome::{NoStart, Outcome};
use crate::rest::{NoRest, Rest, rest};
use crate::simulate::{Request, simulate};
use crate::turn::{NoTurn, Turn, turn, turns};

/// A mechanism whose size is hidden.
pub trait Scene {
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

struct Sized<X, const N: usize, const M: usize>(PhantomData<X>);

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
    fn visit<X: Mechanism<N, M> + 'static, const N: usize, const M: usize>(&mut self) {
        self.scenes.push(Box::new(Sized::<X, N, M>(PhantomData)));
    }
}
