//! Why a scene has no steady motion, in words.

use std::f64::consts::TAU;

use qrm_sim::analysis::NoSteadyMotion;
use qrm_sim::position::Start;

use crate::commands::sensitivity::no_sensitivity;
use crate::error::Error;
use crate::format::{number, seconds};
use crate::setup::Setup;

/// The most cycles that are proposed.
const MOST_CYCLES: u32 = 24;

/// The error of a search for a motion of so many cycles that found none.
pub(super) fn error(setup: &Setup, cycles: u32, reason: NoSteadyMotion) -> Error {
    let name = |coordinate: usize| setup.description.coordinates[coordinate].name;
    let scene = setup.description.name;
    match reason {
        NoSteadyMotion::Start(reason) => setup.no_start(&reason),
        NoSteadyMotion::NotGiven => {
            Error::usage(format!("the start of scene `{scene}` gives more or fewer coordinates than rates"))
                .help("give as many of each under [initial] as there are degrees of freedom")
        }
        NoSteadyMotion::NoPhase => {
            Error::usage(format!("scene `{scene}` gives no coordinate at its start that could tell a cycle"))
                .help("give one under [initial]")
        }
        NoSteadyMotion::FixedSteps => {
            Error::usage("the method has fixed steps, and the period is not known before").help("choose `dop853`")
        }
        NoSteadyMotion::Settling { t, error } => {
            let message = setup.step_error(&error);
            message.after(&format!("the motion before the search breaks off after t = {}: ", seconds(t))).into()
        }
        NoSteadyMotion::AtRest { t } => {
            Error::run(format!("the mechanism stops: by t = {} its motion has died down", seconds(t)))
                .help("a motion without a drive or a motor has no period unless nothing brakes it")
        }
        NoSteadyMotion::LeadsToRest => Error::run("no periodic motion was found: the search leads to a state of rest")
            .help("a motion without a drive or a motor has no period unless nothing brakes it"),
        NoSteadyMotion::NoCycle { coordinate, last, t } => {
            let (name, since) =
                (name(coordinate), if last > 0.0 { format!(" after t = {}", seconds(last)) } else { String::new() });
            Error::run(format!("`{name}` neither turns nor changes its direction{since}, up to t = {}", seconds(t)))
                .help("choose the coordinate of a cycle by --phase, or begin elsewhere with --start")
        }
        NoSteadyMotion::Motion(reason) => no_sensitivity(setup, &reason),
        NoSteadyMotion::NotFound { residual, start, .. } if residual.is_nan() => Error::run(format!(
            "no motion was found behind {}: it jumps to another, or the mechanism cannot be assembled, or loads have \
             no common period there",
            start_values(setup, &start)
        )),
        NoSteadyMotion::NotFound { residual, start, period } => {
            let others = if cycles == 1 { "; a motion may also repeat after more cycles: --cycles 2" } else { "" };
            Error::run(format!(
                "no periodic motion was found. Nearest is {}, where end and start of a period of {} s differ by \
                 {residual:.1e} of their ranges",
                start_values(setup, &start),
                number(period)
            ))
            .help(format!(
                "begin nearer to it with --start and --settle 0, or let the motion settle longer with --settle{others}"
            ))
        }
        NoSteadyMotion::OtherBranch { coordinate, difference } => {
            let unit = setup.description.coordinates[coordinate].unit;
            let text = format!(
                "the coordinates that the start gives return after a period, and `{}` is {} {unit} from its start: it \
                 needs more cycles, or is on another branch",
                name(coordinate),
                number(difference)
            );
            let error = Error::run(text);
            // A gear returns after as many cycles as its ratio says.
            let whole = (2..=MOST_CYCLES).find(|more| {
                let turns = difference * f64::from(*more) / TAU;
                turns.round() != 0.0 && (turns - turns.round()).abs() < 1e-6 && unit == "rad"
            });
            match whole {
                Some(more) => error.help(format!("it returns after {more} times as long: --cycles {}", more * cycles)),
                None if cycles == 1 => error.help("a period of two cycles may return to the same branch: --cycles 2"),
                None => error.help("choose the coordinates under [initial] by which the motion repeats"),
            }
        }
        NoSteadyMotion::LoadsDiffer { quantity, values: [begin, end] } => {
            let what = match quantity {
                Ok(coordinate) => format!("{}_ddot", name(coordinate)),
                Err(constraint) => format!("lambda_{}", setup.description.constraints[constraint].name),
            };
            let others = if cycles == 1 { ": --cycles 2 seeks a period of two" } else { "" };
            Error::run(format!(
                "coordinates and rates return after a period, and the loads do not: `{what}` is {} at some time and {} \
                 a period later",
                number(begin),
                number(end)
            ))
            .help(format!(
                "loads may depend on the number of turns{others}; or on time with another period: --period SECONDS"
            ))
        }
        NoSteadyMotion::OneOfMany => Error::usage(format!(
            "the motion of scene `{scene}` is one of a family of motions at this value of the parameter; a branch \
             needs single motions"
        ))
        .help("add what chooses one of them: a loss, a motor"),
        NoSteadyMotion::PhaseTurnsBack { coordinate } => {
            let name = name(coordinate);
            Error::run(format!("`{name}` turns back where the cycle begins, and tells no phase there"))
                .help("begin the branch there, or choose another coordinate by --phase")
        }
        NoSteadyMotion::NoRange => Error::usage("a branch begins and ends at the same value of its parameter")
            .help("give another end of the range"),
        NoSteadyMotion::NoEigenvalues => Error::run("the linear equations of the search have no finite solution")
            .help("begin elsewhere with --start: the motion may be near a singular position"),
        NoSteadyMotion::Interrupted { t } => {
            Error::run(format!("interrupted at t = {t} s, before the motion was found"))
        }
    }
}

/// The given coordinates and rates of a start, as options.
fn start_values(setup: &Setup, start: &Start) -> String {
    let values = start.given_values(setup.description);
    values.iter().map(|(name, value)| format!("{name}={value}")).collect::<Vec<_>>().join(" ")
}
