//! Why a motion cannot begin or go on, in words.

use std::fmt;

use qrm_core::Description;

use crate::assembly::NotAssembled;
use crate::motion::Breakdown;
use crate::outcome::NoStart;

/// Why a motion cannot begin or go on, with the names of the mechanism it happened to.
#[derive(Clone, Debug)]
pub struct Trouble {
    /// What happened.
    pub reason: Reason,
    /// To which mechanism.
    pub description: Description,
}

/// What can happen to a motion.
#[derive(Clone, Debug, PartialEq)]
pub enum Reason {
    /// It cannot begin.
    NoStart(NoStart),
    /// It broke off after time `t`.
    Broken {
        /// The last time that was reached.
        t: f64,
        /// Why no step leads on.
        breakdown: Breakdown,
    },
    /// What was asked for is no time, or farther away than steps can be made.
    NoTime {
        /// The last time.
        from: f64,
        /// What was asked for.
        to: f64,
    },
    /// No body moves with a mass like this: some motion would have a negative kinetic energy.
    NegativeMass,
    /// A time was asked for that lies before the last one.
    Backwards {
        /// The last time.
        from: f64,
        /// What was asked for.
        to: f64,
    },
}

impl std::error::Error for Trouble {}

impl fmt::Display for Trouble {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let (name, description) = (self.description.name, &self.description);
        match &self.reason {
            Reason::NoStart(NoStart::NotAssembled(reason)) => f.write_str(&not_assembled(reason, description)),
            Reason::NoStart(NoStart::Broken(reason)) => {
                write!(f, "`{name}` cannot start: {}", breakdown(reason, description))
            }
            Reason::NoStart(NoStart::ConditionNotFinite) => {
                write!(f, "`{name}` cannot start: its stop condition has no finite value")
            }
            Reason::NoStart(NoStart::StepTooShort { step, .. }) => {
                write!(f, "`{name}` cannot start: a step of {step} s leads nowhere")
            }
            Reason::Broken { t, breakdown: reason } => {
                write!(f, "`{name}` breaks off after t = {t} s: {}", breakdown(reason, description))
            }
            Reason::NoTime { from, to } => write!(f, "`{name}` has come to t = {from} s and cannot go on to {to} s"),
            Reason::NegativeMass => write!(f, "`{name}` cannot move: some mass or inertia is negative"),
            Reason::Backwards { from, to } => {
                write!(f, "`{name}` has come to t = {from} s and cannot go back to {to} s")
            }
        }
    }
}

fn not_assembled(reason: &NotAssembled, description: &Description) -> String {
    let constraint = &description.constraints[reason.constraint];
    let (name, unit, open) = (constraint.name, constraint.unit, size(reason.residual));
    if reason.rates {
        format!("`{}` cannot start: constraint `{name}` keeps a rate of {open} {unit}/s", description.name)
    } else {
        format!("`{}` cannot be assembled: constraint `{name}` stays {open} {unit} from closed", description.name)
    }
}

/// Why a step could not be made.
pub(crate) fn breakdown(reason: &Breakdown, description: &Description) -> String {
    match reason {
        Breakdown::NotConverged(e) => {
            let constraint = &description.constraints[e.constraint];
            let (name, unit) = (constraint.name, constraint.unit);
            format!(
                "constraint `{name}` could not be closed again after the step: still {:.3e} {unit} open after {} corrections\n  \
                 = help: use a shorter --step, or a smaller --tolerance with a method that chooses its steps; if it happens at the same position with every step, the mechanism is singular there",
                e.residual, e.iterations
            )
        }
        Breakdown::Massless(coordinate) => format!(
            "no mass resists a motion of coordinate `{}` that the constraints allow, so its acceleration is not determined\n  \
             = help: give the bodies that move with it a mass or an inertia",
            description.coordinates[*coordinate].name
        ),
        Breakdown::StepTooShort { h } => format!(
            "steps had to become as short as {h:.1e} s, and time stands still: the tolerance is beyond double precision, or the \
             mechanism is singular here\n  = help: use a larger --tolerance"
        ),
        Breakdown::TooManySteps { attempts, h } => format!(
            "{attempts} steps were tried, now of {h:.1e} s, and the next row is far: the motion is too fast, too stiff or too near \
             a singular position for the tolerance and the time that it is to be followed\n  \
             = help: use a larger --tolerance, an earlier --end-time, or a shorter --step between rows"
        ),
        Breakdown::NotFinite => {
            "the next state is not finite: numbers grew beyond all bounds, or a formula left its domain\n  \
             = help: use a shorter --step, or a smaller --tolerance with a method that chooses its steps; look for roots, logarithms and quotients in the scene"
                .to_owned()
        }
        Breakdown::NoLinearization => format!(
            "the method needs the Jacobians of forces and constraints, and scene `{}` does not ask for them\n  \
             = help: write `stiff = true` under [run] in scenes/{}.toml, and build again",
            description.name, description.name
        ),
    }
}

/// A length or angle, in as many digits as can be read.
pub(crate) fn size(value: f64) -> String {
    if (1e-4..1e6).contains(&value) { format!("{value:.6}") } else { format!("{value:.3e}") }
}
