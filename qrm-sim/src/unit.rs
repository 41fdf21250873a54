//! A motion under way behind an interface that hides the size of its mechanism: numbers under names, for simulation tools.

mod settings;

use qrm_core::{Description, Mechanism, Visitor};

use crate::linear::largest;
use crate::motion::{Method, Moment};
use crate::simulation::Simulation;
use crate::trouble::Trouble;
use crate::walk::parameters;
#[cfg(feature = "sweep")]
pub(crate) use settings::digest;
pub use settings::{Settings, fingerprint};

/// A number of a mechanism that a tool can ask for, or set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Time.
    Time,
    /// A parameter.
    Parameter(usize),
    /// A coordinate.
    Coordinate(usize),
    /// Its rate.
    Rate(usize),
    /// Its acceleration.
    Acceleration(usize),
    /// The multiplier of a constraint.
    Multiplier(usize),
    /// An output.
    Output(usize),
    /// Kinetic energy and potential of the conservative loads.
    Energy,
}

/// Such a number with its name. Its place in [`variables`] is its reference.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Variable {
    /// Its name: that of the column in `trajectory.csv`, or of the parameter.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// What it is.
    pub doc: String,
    /// What it stands for.
    pub kind: Kind,
}

/// The variables of a mechanism: time, parameters, then the columns of a trajectory.
pub fn variables(description: &Description) -> Vec<Variable> {
    let mut variables = Vec::new();
    let mut add = |name: String, unit: String, doc: String, kind| variables.push(Variable { name, unit, doc, kind });
    add("time".to_owned(), "s".to_owned(), "time".to_owned(), Kind::Time);
    for (i, p) in description.parameters.iter().enumerate() {
        add(p.name.to_owned(), p.unit.to_owned(), p.doc.to_owned(), Kind::Parameter(i));
    }
    for (i, c) in description.coordinates.iter().enumerate() {
        add(c.name.to_owned(), c.unit.to_owned(), c.doc.to_owned(), Kind::Coordinate(i));
        let doc = |what: &str| format!("{what} of {}", c.name);
        add(format!("{}_dot", c.name), per_second(c.unit, 1), doc("rate"), Kind::Rate(i));
        add(format!("{}_ddot", c.name), per_second(c.unit, 2), doc("acceleration"), Kind::Acceleration(i));
    }
    for (i, c) in description.constraints.iter().enumerate() {
        let doc = format!("multiplier of constraint {}: {}", c.name, c.doc);
        let unit = if c.unit == "m" { "N" } else { "" };
        add(
            format!("lambda_{}", c.name),
            unit.to_owned(),
            doc.trim_end_matches([':', ' ']).to_owned(),
            Kind::Multiplier(i),
        );
    }
    for (i, o) in description.outputs.iter().enumerate() {
        add(o.name.to_owned(), o.unit.to_owned(), o.doc.to_owned(), Kind::Output(i));
    }
    let energy = "kinetic energy and potential of the conservative loads";
    add("energy".to_owned(), "J".to_owned(), energy.to_owned(), Kind::Energy);
    variables
}

/// The unit of a rate of something.
pub fn per_second(unit: &str, order: u32) -> String {
    let seconds = if order == 1 { "s".to_owned() } else { format!("s^{order}") };
    match unit {
        "" | "1" => format!("1/{seconds}"),
        unit if unit.contains('/') => format!("({unit})/{seconds}"),
        unit => format!("{unit}/{seconds}"),
    }
}

/// A motion under way, whatever the size of its mechanism.
pub trait Unit: Send {
    /// The present value of a variable; not a number where there is none of that kind.
    fn value(&self, kind: Kind) -> f64;

    /// Goes on to a time not before the last one.
    ///
    /// # Errors
    /// The motion does not get there; it stays where it is.
    fn advance(&mut self, t: f64) -> Result<(), Trouble>;

    /// Goes on with other parameters, from where the motion is.
    ///
    /// # Errors
    /// That is not possible; nothing has changed.
    fn replace(&mut self, replace: &dyn Fn(&str) -> Option<f64>) -> Result<(), Trouble>;

    /// Puts coordinates and rates, in this order, at a time: for a tool that integrates by itself.
    ///
    /// # Errors
    /// The accelerations are not determined there; nothing has changed.
    fn place(&mut self, t: f64, states: &[f64]) -> Result<(), Trouble>;

    /// Largest residual of a constraint, and of its rate.
    fn open(&self) -> f64;

    /// Another motion in the same state.
    fn copy(&self) -> Box<dyn Unit>;
}

impl<X: Mechanism<N, M> + Clone + Send + 'static, const N: usize, const M: usize> Unit for Simulation<X, N, M> {
    fn value(&self, kind: Kind) -> f64 {
        let Moment { t, q, qd, qdd, multipliers, .. } = self.now();
        let at = |values: &[f64], i: usize| values.get(i).copied().unwrap_or(f64::NAN);
        match kind {
            Kind::Time => *t,
            Kind::Parameter(i) => at(self.parameters(), i),
            Kind::Coordinate(i) => at(q, i),
            Kind::Rate(i) => at(qd, i),
            Kind::Acceleration(i) => at(qdd, i),
            Kind::Multiplier(i) => at(multipliers, i),
            Kind::Output(i) => {
                let mut outputs = vec![f64::NAN; X::DESCRIPTION.outputs.len()];
                self.outputs(&mut outputs);
                at(&outputs, i)
            }
            Kind::Energy => self.mechanism().energy(q, qd).iter().sum(),
        }
    }

    fn advance(&mut self, t: f64) -> Result<(), Trouble> {
        Simulation::advance(self, t).map(|_| ())
    }

    fn replace(&mut self, replace: &dyn Fn(&str) -> Option<f64>) -> Result<(), Trouble> {
        Simulation::replace(self, X::with_parameters(replace))
    }

    fn place(&mut self, t: f64, states: &[f64]) -> Result<(), Trouble> {
        let part = |from: usize| core::array::from_fn(|i| states.get(from + i).copied().unwrap_or(f64::NAN));
        Simulation::place(self, t, part(0), part(N))
    }

    fn open(&self) -> f64 {
        let Moment { t, q, qd, .. } = self.now();
        let closure = self.mechanism().closure(*t, q);
        largest(&closure.constraints).1.max(largest(&closure.drift(qd)).1)
    }

    fn copy(&self) -> Box<dyn Unit> {
        Box::new(self.clone())
    }
}

/// Begins a motion with some parameters replaced.
pub type Begin = fn(&dyn Fn(&str) -> Option<f64>, Method, Option<f64>) -> Result<Box<dyn Unit>, Trouble>;

/// The values of a mechanism's parameters, some of them replaced.
pub type Parameters = fn(&dyn Fn(&str) -> Option<f64>) -> Vec<f64>;

/// A mechanism of a program.
#[derive(Clone, Copy)]
pub struct Entry {
    /// Names, units and meanings.
    pub description: &'static Description,
    /// How its motion begins.
    pub begin: Begin,
    /// The values of its parameters, some of them replaced.
    pub parameters: Parameters,
}

/// The mechanisms that a program was built with; fill it as a [`Visitor`].
#[derive(Default)]
pub struct Units {
    units: Vec<Entry>,
}

impl Units {
    /// The mechanism of this name.
    pub fn find(&self, name: &str) -> Option<Entry> {
        self.units.iter().find(|entry| entry.description.name == name).copied()
    }
}

impl Visitor for Units {
    fn visit<X: Mechanism<N, M> + Clone + Send + 'static, const N: usize, const M: usize>(&mut self) {
        self.units.push(Entry {
            description: const { &X::DESCRIPTION },
            begin: begin::<X, N, M>,
            parameters: |replace| parameters(&X::with_parameters(replace)),
        });
    }
}

fn begin<X: Mechanism<N, M> + Clone + Send + 'static, const N: usize, const M: usize>(
    replace: &dyn Fn(&str) -> Option<f64>,
    method: Method,
    step: Option<f64>,
) -> Result<Box<dyn Unit>, Trouble> {
    Ok(Box::new(Simulation::<X, N, M>::new(X::with_parameters(replace), method, step)?))
}
