//! The error of a motion that cannot begin or continue.

use std::fmt;

use qrm_core::Description;

use super::judgement::RejectionReason;
use super::outcome::StartError;
use crate::integrate::StepError;
use crate::position::NotAssembled;

/// The reason why a motion cannot begin or continue, with the names of its mechanism.
#[derive(Clone, Debug)]
pub struct SimError {
    /// The reason.
    pub reason: Reason,
    /// Names, units and descriptions of the mechanism.
    pub description: &'static Description,
}

/// A reason why a motion cannot begin or continue.
#[derive(Clone, Debug, PartialEq)]
pub enum Reason {
    /// The motion cannot begin.
    Start(StartError),
    /// The motion failed after time `t`.
    Failed {
        /// The last time reached.
        t: f64,
        /// The reason why no step can be made.
        error: StepError,
    },
    /// The requested time is not a number, or too far away.
    NoTime {
        /// The last time.
        from: f64,
        /// The requested time.
        to: f64,
    },
    /// The results of the motion cannot be trusted.
    Doubtful {
        /// The time up to which it was followed.
        t: f64,
        /// The reasons.
        rejection_reasons: Vec<RejectionReason>,
        /// The tolerance of a method that chooses its steps.
        tolerance: Option<f64>,
    },
    /// The kinetic energy is negative for some motion.
    NegativeMass,
    /// The requested time lies before the last one.
    Backwards {
        /// The last time.
        from: f64,
        /// The requested time.
        to: f64,
    },
}

impl std::error::Error for SimError {}

impl fmt::Display for SimError {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let (name, description) = (self.description.name, self.description);
        match &self.reason {
            Reason::Start(StartError::NotAssembled(reason)) => f.write_str(&not_assembled(reason, description)),
            Reason::Start(StartError::Step(reason)) => {
                write!(f, "`{name}` cannot start: {}", reason.explain(description))
            }
            Reason::Start(StartError::RateNotDetermined(coordinate)) => {
                let coordinate = description.coordinates[*coordinate].name;
                write!(f, "`{name}` cannot start: its given rates do not determine that of `{coordinate}`")
            }
            Reason::Start(StartError::ConditionNotFinite) => {
                write!(f, "`{name}` cannot start: its stop condition has no finite value")
            }
            Reason::Start(StartError::ConditionHolds) => {
                write!(f, "`{name}` cannot start: its stop condition holds already")
            }
            Reason::Start(StartError::StepTooShort { step, .. }) => {
                write!(f, "`{name}` cannot start: a step of {step} s leads nowhere")
            }
            Reason::Failed { t, error: reason } => {
                write!(f, "`{name}` breaks off after t = {t} s: {}", reason.explain(description))
            }
            Reason::NoTime { from, to } => write!(f, "`{name}` has come to t = {from} s and cannot go on to {to:?} s"),
            Reason::Doubtful { t, rejection_reasons, tolerance } => {
                let texts: Vec<String> =
                    rejection_reasons.iter().map(|reason| reason.text(*tolerance, description)).collect();
                let help = match tolerance {
                    Some(_) => "use a smaller tolerance",
                    None => "use a shorter step, or a method that chooses its steps",
                };
                let (text, help) = (format!("do not trust the numbers: {}", texts.join("; and ")), help.to_owned());
                write!(f, "`{name}` at t = {t} s: {}", Explanation { text, help })
            }
            Reason::NegativeMass => write!(f, "`{name}` cannot move: some mass or inertia is negative"),
            Reason::Backwards { from, to } => {
                write!(f, "`{name}` has come to t = {from} s and cannot go back to {to} s")
            }
        }
    }
}

fn not_assembled(reason: &NotAssembled, description: &Description) -> String {
    let constraint = &description.constraints[reason.constraint];
    let (name, unit, open) = (constraint.name, constraint.unit, readable_size(reason.residual));
    if reason.is_other_branch {
        format!("`{}` can be assembled only on another branch than with its own parameters", description.name)
    } else if reason.rates {
        format!("`{}` cannot start: constraint `{name}` keeps a rate of {open} {unit}/s", description.name)
    } else {
        format!("`{}` cannot be assembled: constraint `{name}` stays {open} {unit} from closed", description.name)
    }
}

/// A problem and its remedy, each in a sentence.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Explanation {
    /// The problem.
    pub text: String,
    /// The remedy; empty in a page, where no option can be given.
    pub help: String,
}

impl fmt::Display for Explanation {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.text)?;
        if self.help.is_empty() { Ok(()) } else { write!(f, "\n  = help: {}", self.help) }
    }
}

impl StepError {
    /// Explains why the step could not be made, with the names of the mechanism.
    pub fn explain(&self, description: &Description) -> Explanation {
        let help = if cfg!(feature = "events") { self.help(description) } else { String::new() };
        Explanation { text: self.text(description), help }
    }

    /// The reason why the step could not be made, with the names of the mechanism.
    fn text(&self, description: &Description) -> String {
        match self {
            Self::NotConverged(e) => {
                let constraint = &description.constraints[e.constraint];
                let (name, unit) = (constraint.name, constraint.unit);
                format!(
                    "constraint `{name}` could not be closed again after the step: still {:.3e} {unit} open after {} \
                     corrections",
                    e.residual, e.iterations
                )
            }
            Self::Massless(coordinate) => {
                let name = description.coordinates[*coordinate].name;
                format!(
                    "no mass resists a motion of coordinate `{name}` that the constraints allow, so its acceleration \
                     is not determined"
                )
            }
            Self::StepTooShort { h } => format!(
                "steps had to become as short as {h:.1e} s, which does not advance the time: the tolerance is beyond \
                 double precision, or the mechanism is singular here, or without inertia"
            ),
            Self::TooManySteps { attempts, h } => format!(
                "{attempts} steps were tried, now of {h:.1e} s, and the next row is far: the motion is too fast, too \
                 stiff or too near a singular position for the tolerance and the time that it is to be followed"
            ),
            Self::ForcesNotFinite if !description.friction.is_empty() => format!(
                "the friction of {} has no solution or several at this position and speed (Painleve's paradox), or \
                 the mechanism is singular here, or another force is not finite",
                description.friction.join(", ")
            ),
            Self::NoGradient(constraint) => format!(
                "constraint `{}` has no gradient wherever it is closed, so no force can hold it, and neither the \
                 motion nor the forces are determined",
                description.constraints[*constraint].name
            ),
            Self::FrictionNotUnique => format!(
                "constraints repeat others, so that the forces in joints are not unique, and the friction of {} \
                 depends on them",
                description.friction.join(", ")
            ),
            Self::NotFinite | Self::ForcesNotFinite => {
                "the next state is not finite: numbers grew beyond all bounds, or a formula left its domain".to_owned()
            }
            Self::NoLinearization if !description.friction.is_empty() => {
                "the method needs Jacobians, and there are none of friction that depends on forces in joints".to_owned()
            }
            Self::NoLinearization => format!(
                "the method needs the Jacobians of forces and constraints, and scene `{}` does not ask for them",
                description.name
            ),
        }
    }

    /// The remedy, in terms of the command line.
    fn help(&self, description: &Description) -> String {
        let help = match self {
            Self::NotConverged(_) => {
                "use a shorter --step, or a smaller --tolerance with a method that chooses its steps; if it happens at \
                 the same position with every step, the mechanism is singular there"
            }
            Self::Massless(_) => "give the bodies that move with it a mass or an inertia",
            Self::StepTooShort { .. } => "use a larger --tolerance",
            Self::TooManySteps { .. } => {
                "use a larger --tolerance, an earlier --end-time, or a shorter --step between rows"
            }
            Self::ForcesNotFinite if !description.friction.is_empty() => {
                "use a smaller coefficient of friction, a longer guide, or a larger `slip`"
            }
            Self::NoGradient(_) => {
                "write it in a form with a gradient, such as `y = 0` for `hypot(x, y) = x`; a joint that others hold \
                 at the end of its reach is to be left out, or a length changed"
            }
            Self::FrictionNotUnique => {
                "take out the constraints that are too many (without friction `qrm check` names them), or the friction"
            }
            Self::NotFinite | Self::ForcesNotFinite => {
                "use a shorter --step, or a smaller --tolerance with a method that chooses its steps; look for roots, \
                 logarithms and quotients in the scene"
            }
            Self::NoLinearization if !description.friction.is_empty() => "use `--method dop853` or `gauss`",
            Self::NoLinearization => {
                let name = description.name;
                return format!("write `stiff = true` under [run] in scenes/{name}.toml, and build again");
            }
        };
        help.to_owned()
    }
}

/// A length or angle in readable digits.
pub fn readable_size(value: f64) -> String {
    if (1e-4..1e6).contains(&value) { format!("{value:.6}") } else { format!("{value:.3e}") }
}
