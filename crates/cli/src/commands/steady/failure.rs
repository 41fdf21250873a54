//! Why a scene has no steady motion, in words.

use qrm_sim::analysis::NoSteadyMotion;
use qrm_sim::position::Start;

use crate::commands::sensitivity::no_sensitivity;
use crate::error::Error;
use crate::format::{number, quantity, seconds};
use crate::setup::Setup;

/// The error of a search that found no steady motion.
pub(super) fn error(setup: &Setup, reason: NoSteadyMotion) -> Error {
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
        NoSteadyMotion::Settling { t, error } => {
            let message = setup.step_error(&error);
            message.after(&format!("the motion before the search breaks off after t = {}: ", seconds(t))).into()
        }
        NoSteadyMotion::AtRest { t } => Error::run(format!(
            "the mechanism comes to rest: by t = {} its motion has died down",
            seconds(t)
        ))
        .help("a motion without a drive or a motor has no period unless nothing brakes it"),
        NoSteadyMotion::LeadsToRest => Error::run("no periodic motion was found: the search leads to a state of rest")
            .help("a motion without a drive or a motor has no period unless nothing brakes it"),
        NoSteadyMotion::NoCycle { coordinate, last, t } => {
            let (name, since) = (name(coordinate), if last > 0.0 { format!(" after t = {}", seconds(last)) } else { String::new() });
            Error::run(format!("`{name}` neither turns nor changes its direction{since}, up to t = {}", seconds(t)))
                .help("choose the coordinate of a cycle by --phase, or begin elsewhere with --start")
        }
        NoSteadyMotion::Motion(reason) => no_sensitivity(setup, &reason),
        NoSteadyMotion::NotFound { residual, start, period } => Error::run(format!(
            "no periodic motion was found. Nearest is {}, where end and start of a period of {} s differ by {residual:.1e} \
             of their ranges",
            start_values(setup, &start),
            number(period)
        ))
        .help(
            "begin nearer to it with --start and --settle 0, or let the motion settle longer with --settle; a motion may \
             also repeat after two or more cycles only: --cycles 2",
        ),
        NoSteadyMotion::OtherBranch { coordinate, difference } => {
            let unit = setup.description.coordinates[coordinate].unit;
            Error::run(format!(
                "the coordinates that the start gives return after a period, and `{}` does not: it is {} away, on another \
                 branch",
                name(coordinate),
                quantity(difference, unit)
            ))
            .help("a period of two cycles may return to the same branch: --cycles 2")
        }
        NoSteadyMotion::LoadsDiffer { quantity, values: [begin, end] } => {
            let what = match quantity {
                Ok(coordinate) => format!("{}_ddot", name(coordinate)),
                Err(constraint) => format!("lambda_{}", setup.description.constraints[constraint].name),
            };
            Error::run(format!(
                "coordinates and rates return after a period, and the loads do not: `{what}` is {} at some time \
                 and {} a period later",
                number(begin),
                number(end)
            ))
            .help(
                "loads may depend on the number of turns: --cycles 2 seeks a period of two; or on time with another \
                 period: --period SECONDS",
            )
        }
        NoSteadyMotion::NoEigenvalues => Error::run("the linear equations of the search have no finite solution")
            .help("begin elsewhere with --start: the motion may be near a singular position"),
        NoSteadyMotion::Interrupted { t } => Error::run(format!("interrupted at t = {t} s, before the motion was found")),
    }
}

/// The given coordinates and rates of a start, as options.
fn start_values(setup: &Setup, start: &Start) -> String {
    let values = start.given_values(setup.description);
    values.iter().map(|(name, value)| format!("{name}={value}")).collect::<Vec<_>>().join(" ")
}
