//! Messages about motions that fail to begin, to continue, or to end.

use qrm_scene::diagnostic::Diagnostic;
use qrm_sim::integrate::StepError;
use qrm_sim::position::NotAssembled;
use qrm_sim::run::{Explanation, NonFiniteQuantity, StartError, Status, readable_size};

use crate::error::{Error, Message};
use crate::format::{counted, number, seconds, with_error};
use crate::setup::Setup;

/// How to follow a motion along a jump of a load.
pub(crate) const WITHOUT_JUMPS: &str = "if the motion sticks where `sign` in a load jumps, no step can follow it: \
                                        write `tanh(x/x0)` with a small x0 instead, or `friction` at a joint";

impl Setup {
    /// An error for a run that could not begin, with its location in the scene if there is one.
    pub(crate) fn no_start(&self, reason: &StartError) -> Error {
        match reason {
            StartError::NotAssembled(reason) => self.not_assembled(reason),
            StartError::Step(StepError::NotFinite | StepError::ForcesNotFinite)
                if self.description.friction.is_empty() =>
            {
                Error::usage("the run cannot start: the accelerations are not finite")
                    .help("some parameter is too large or too small for double precision")
            }
            StartError::Step(reason) => {
                let Message { text, help } = self.step_error(reason).after("the run cannot start: ");
                let error = Error::usage(text);
                help.into_iter().fold(error, Error::help)
            }
            StartError::RateNotDetermined(coordinate) => {
                let name = self.description.coordinates[*coordinate].name;
                let text = format!(
                    "the run cannot start: at this dead point the given rates do not determine the rate of `{name}`"
                );
                Error::usage(text).help("begin elsewhere, or give the rate of another coordinate")
            }
            StartError::ConditionNotFinite => Error::usage("the stop condition has no finite value at the start")
                .help("look for divisions by zero, roots and logarithms in it"),
            StartError::ConditionHolds => {
                Error::usage(format!("`{}` holds at the start: there is no motion to compute", self.until))
                    .help("begin elsewhere, or end with another --until or --end-time")
            }
            StartError::StepTooShort { step, end_time } => {
                let (step, end) = (seconds(*step), seconds(*end_time));
                Error::usage(format!(
                    "a step of {step} is too short for a run of {end}: it is below the resolution of the time"
                ))
                .help("use a longer step or an earlier end")
            }
        }
    }

    /// The reason why a method does not reach the last time.
    pub(crate) fn no_end(&self, reason: &StartError) -> Message {
        match reason {
            StartError::Step(StepError::NotFinite | StepError::ForcesNotFinite)
                if self.description.friction.is_empty() =>
            {
                Message::new("breaks off: the state became infinite")
            }
            StartError::Step(reason) => self.step_error(reason).after("breaks off: "),
            other => self.no_start(other).message(),
        }
    }

    /// An error for constraints that cannot be satisfied, with their location in the scene.
    pub(crate) fn not_assembled(&self, reason: &NotAssembled) -> Error {
        let constraint = &self.scene.constraints[reason.constraint];
        let (name, unit, span) = (&constraint.name, &constraint.unit, constraint.span.clone());
        let size = readable_size(reason.residual);
        let [guesses, rates, positions] = if self.scene.has_links {
            ["`angle`s of links and places `near` joints", "`rate`s of links and sliders", "`angle`s and `start`s"]
        } else {
            ["guesses in [initial]", "rates in [initial]", "positions"]
        };
        if reason.is_other_branch {
            let help = format!("on the way there it passes a singular position; choose {guesses} on that branch");
            return Error::usage("the mechanism can be assembled only on another branch than that of the scene")
                .help(help);
        }
        let diagnostic = if reason.rates {
            let title = format!(
                "the rates at the start cannot be solved for: constraint `{name}` keeps a rate of {size} {unit}/s"
            );
            let help = if constraint.is_drive {
                format!("a drive prescribes a rate of its own: remove the {rates} that differ from it")
            } else {
                format!(
                    "give no more {rates} than there are degrees of freedom; if there are not, the mechanism starts at \
                     a dead point for the coordinate that is given: start elsewhere, or give another rate"
                )
            };
            Diagnostic::error(title, span, "cannot stay closed with the given rates").help(help)
        } else if !reason.residual.is_finite() {
            let title = format!("constraint `{name}` has no value at the first guesses");
            Diagnostic::error(title, span, "a root or another function leaves its domain")
                .help(format!("choose other {guesses}"))
        } else {
            let found = self.scene.coordinates.iter().zip(&reason.q).map(|(c, q)| format!("{} = {q:.6}", c.name));
            let found = found.collect::<Vec<_>>().join(", ");
            let title =
                format!("the mechanism cannot be assembled: constraint `{name}` stays {size} {unit} from closed");
            let label = format!("not zero anywhere near the first guesses; nearest at {found}");
            let others = if self.scene.has_links { "" } else { ", and the others as guesses in `solve`" };
            if let Some(help) = self.too_many_drives().or_else(|| self.given_beside_drives()) {
                return self.at_place(Diagnostic::error(title, span, label).help(help));
            }
            Diagnostic::error(title, span, label).help(format!(
                "check the lengths that occur here, or choose other {guesses}; give no more {positions} than there are \
                 degrees of freedom{others}"
            ))
        };
        self.at_place(diagnostic)
    }

    /// Help for a mechanism with more drives than degrees of freedom.
    fn too_many_drives(&self) -> Option<String> {
        let drives = self.scene.drives().len();
        let closures = self.scene.constraints.len() - drives;
        let freedoms = self.scene.coordinates.len().saturating_sub(closures);
        let count = if freedoms == 1 { "1 degree".to_owned() } else { format!("{freedoms} degrees") };
        let help = format!(
            "the mechanism has {} and {count} of freedom: take one drive away",
            counted(drives as u64, "drive")
        );
        (drives > freedoms).then_some(help)
    }

    /// Help for a mechanism of links whose drives leave fewer degrees of freedom than coordinates are given.
    fn given_beside_drives(&self) -> Option<String> {
        let drives = self.scene.drives().len();
        let freedoms = self.scene.coordinates.len().saturating_sub(self.scene.constraints.len());
        let given = self.start().given.iter().filter(|given| **given).count();
        let help = format!(
            "{} given at the start, and the drives leave {}: take the `rate` of a link or a slider out",
            if given == 1 { "1 coordinate is".to_owned() } else { format!("{given} coordinates are") },
            if freedoms == 0 {
                "no degree of freedom".to_owned()
            } else {
                counted(freedoms as u64, "degree") + " of freedom"
            },
        );
        (self.scene.has_links && drives > 0 && given > freedoms).then_some(help)
    }

    /// The reason why a step could not be made.
    pub(crate) fn step_error(&self, reason: &StepError) -> Message {
        let Explanation { text, help } = reason.explain(self.description);
        let is_stuck = matches!(reason, StepError::StepTooShort { .. } | StepError::TooManySteps { .. });
        Message::new(text).help(if is_stuck && self.scene.has_jumps() { WITHOUT_JUMPS.to_owned() } else { help })
    }

    /// Describes the end of a run, at a time with an error, in a few sentences.
    pub(crate) fn status(&self, status: &Status, (end_time, error): (f64, Option<f64>)) -> Message {
        let (description, until) = (self.description, &self.until);
        let t = error.map_or_else(|| seconds(end_time), |error| format!("{} s", with_error(end_time, error)));
        Message::new(match status {
            Status::Completed => format!("reached the end time {t}"),
            Status::Stopped => format!("`{until}` reached at t = {t}"),
            Status::StopNotReached { nearest_time, missing } => {
                let since =
                    if *nearest_time < end_time { "and has moved away since" } else { "and was still coming nearer" };
                format!(
                    "`{until}` did not become true by the latest end, t = {t}: it was nearest at t = {}, {} short, \
                 {since}",
                    seconds(*nearest_time),
                    number(*missing)
                )
            }
            Status::StopUndecided { between: [begin, end] } => format!(
                "whether `{until}` becomes true between t = {begin} s and {end} s is not known: its terms change too \
                 fast there"
            ),
            Status::Interrupted => format!("interrupted at t = {t}"),
            Status::Failed(reason) => {
                return self.step_error(reason).after(&format!("broke off after t = {t}: "));
            }
            Status::NotFinite { t, what } => {
                let what = match what {
                    NonFiniteQuantity::Output(i) => format!("output `{}`", description.outputs[*i].name),
                    NonFiniteQuantity::Energy => "the energy".to_owned(),
                    NonFiniteQuantity::Condition => format!("the stop condition `{until}`"),
                };
                format!("{what} is not finite at t = {}; the rows before that are kept", seconds(*t))
            }
            Status::Unwritable(e) if e.kind() == std::io::ErrorKind::OutOfMemory => {
                return Message::new(format!("the rows fill the memory at t = {t}"))
                    .help("keep fewer of them, for instance with `--every 100`");
            }
            Status::Unwritable(e) => format!("a row could not be written: {e}"),
        })
    }
}
