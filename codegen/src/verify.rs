//! Runs a tape before it is written, and compares it with the scene itself. Formulae are evaluated with automatic
//! differentiation, which shares no code with the engine or the graph.

mod accuracy;
mod adjoint;
mod equations;
mod errors;
mod evaluation;
mod expected;
mod friction;
mod gradients;
mod hessians;
mod kernel;
mod linearization;
mod loads;
mod sample;
mod size;
mod system;
mod tape;
mod tree;
mod virtual_work;
mod wide;

use qrm_core::{DoubleDouble, NamedTape, Tape};

use crate::term::Equations;
pub use accuracy::{Accuracy, accuracy};
use errors::{Errors, has_rounded_constants};
pub(crate) use evaluation::Evaluation;
#[cfg(test)]
pub(crate) use evaluation::Number;
use expected::Expected;
use hessians::second_derivatives;
use qrm_scene::evaluate::{State, constant, evaluate, parameter_values};
use qrm_scene::expression::Node;
use qrm_scene::resolve::all_values;
use qrm_scene::scene::{Coordinate, Quantity, Scene, Start, Value as Formula};
use sample::Sample;
use size::{SMALLEST, TINY, size};
use wide::Wide;

/// The number of random states; fewer for large mechanisms, whose matrices are mostly zeros.
const STATES: usize = 40;
/// The number of compared coordinate values, which determines the number of random states in larger scenes.
const NUMBERS: usize = 400;
/// The number of random states per valid one that may lie outside the domain of the formulae.
const MAX_INVALID_RATIO: usize = 50;
/// The number of random states per requested one in scenes whose friction depends on joint forces.
const FRICTION_MAX_INVALID_RATIO: usize = 3;
/// The largest difference of a number, relative to itself or to a thousandth of its largest value in all states. Both
/// sides have 32 digits, but numbers in the text of a module have 16.
const TOLERANCE: f64 = 1e-12;
/// The reason why a module must not be written.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Unverified {
    /// A function does not compute what the scene says.
    #[error("{0}\nnothing was written; this is a mistake of the generator, please report it with the scene")]
    Wrong(String),
    /// The formulae have no value in almost all states.
    #[error("{0}\n  = help: look for roots and logarithms of negative numbers, and for numbers beyond 1e308")]
    NoDomain(String),
    /// The scene requests forces that are not determined, or its friction depends on such forces.
    #[error("{0}")]
    Undetermined(String),
}

/// Compares the tape with its scene at random states, half of them near the start, and compares evaluators with the
/// tape.
///
/// # Errors
/// The function that differs, with the difference and its location; or the reason why the scene has no values for a
/// comparison.
pub fn verify(scene: &Scene, equations: &Equations, tape: &NamedTape, placed: &Tape) -> Result<(), Unverified> {
    let states = (NUMBERS / scene.coordinates.len().max(1)).clamp(STATES / 5, STATES);
    let mut random = fastrand::Rng::with_seed(1);
    // If forces are not determined, this holds at every position.
    let max_invalid_ratio =
        if scene.normal_forces().is_empty() { MAX_INVALID_RATIO } else { FRICTION_MAX_INVALID_RATIO };
    let samples = (0..states * max_invalid_ratio).map(|number| Sample::random(scene, number, &mut random));
    let known =
        samples.filter_map(|sample| sample.on::<Wide>().expected(scene, equations).map(|expected| (sample, expected)));
    let known: Vec<(Sample, Expected<Wide>)> = known.take(states).collect();
    let mut random = fastrand::Rng::with_seed(3);
    let random = (0..states).map(|_| Sample::random_of_order_one(scene, &mut random));
    let random = random.filter_map(|s| s.on::<Wide>().expected(scene, equations).map(|expected| (s, expected)));
    let random: Vec<(Sample, Expected<Wide>)> = random.take(states / 4).collect();
    if scene.run.inverse && tape.function("inverse_dynamics").is_none() {
        return Err(Unverified::Undetermined(format!(
            "error: scene `{}` asks for inverse dynamics, but its constraints repeat others\n  = help: take out the \
             constraints that are too many, or `inverse = true` under [run]",
            scene.name
        )));
    }
    let has_rounded_constants = has_rounded_constants(scene);
    let mut agreed = 0;
    for (samples, counts) in [(&known, true), (&random, false)] {
        let scales = scales(samples);
        for (sample, expected) in samples {
            let second = second_derivatives(scene, equations, sample, has_rounded_constants);
            let agrees = agrees(scene, equations, tape, (sample, expected), &scales);
            let wrong = |difference| Unverified::Wrong(format!("scene `{}`: {difference}\nat {sample:?}", scene.name));
            second.map_err(wrong)?;
            let kernel_agrees = kernel::agrees(scene, equations, tape, (sample, expected));
            agreed += usize::from(agrees.map_err(wrong)? && counts);
            kernel_agrees.map_err(wrong)?;
            tape::agrees(scene, tape, placed, sample).map_err(wrong)?;
        }
    }
    let problem = if known.len() < states / 4 && !scene.normal_forces().is_empty() {
        return Err(Unverified::Undetermined(format!(
            "error: friction of scene `{}` depends on forces that are not determined at {} of {} random states\n  = \
             help: take out constraints that repeat others, or use a smaller coefficient of friction",
            scene.name,
            states * max_invalid_ratio - known.len(),
            states * max_invalid_ratio
        )));
    } else if known.len() < states / 4 {
        format!("have a value at only {} of {} random states", known.len(), states * MAX_INVALID_RATIO)
    } else if agreed < states / 4 {
        format!(
            "are at {} of {} random states so sensitive that nothing can be compared",
            known.len() - agreed,
            known.len()
        )
    } else {
        let plain = verify_plain(scene, tape).and_then(|()| tape::agrees_at_start(scene, tape, placed));
        return plain.map_err(Unverified::Wrong);
    };
    Err(Unverified::NoDomain(format!("error: the formulae of scene `{}` {problem}", scene.name)))
}

/// The largest absolute value of each number of each function in all states.
fn scales(known: &[(Sample, Expected<Wide>)]) -> Vec<Vec<f64>> {
    let Some((_, first)) = known.first() else { return Vec::new() };
    let mut scales: Vec<Vec<f64>> = first.iter().map(|(_, numbers)| vec![0.0; numbers.len()]).collect();
    for (_, expected) in known {
        for (scales, (_, numbers)) in scales.iter_mut().zip(expected) {
            scales.iter_mut().zip(numbers).for_each(|(scale, number)| *scale = scale.max(size(*number)));
        }
    }
    scales
}

/// The largest number of any function except outputs in all states. Terms that cancel in one number may be as large as
/// the others: without gravity, all terms in a pendulum's linearization cancel.
fn largest(expected: &Expected<Wide>, scales: &[Vec<f64>]) -> f64 {
    let of_equations = expected.iter().zip(scales).filter(|((name, _), _)| *name != "outputs");
    of_equations.flat_map(|(_, scales)| scales).fold(0.0, |most: f64, &scale| most.max(scale))
}

/// The largest number in a formula; terms that contain it may cancel.
fn largest_constant(scene: &Scene) -> f64 {
    let of_node = |node: &Node<Quantity>| if let Node::Number(number) = node { number.value.abs() } else { 0.0 };
    all_values(scene).iter().flat_map(|value| value.nodes().iter().map(of_node)).fold(0.0, f64::max)
}

/// Whether every function returns the expected values; `false` if the expected numbers are too inaccurate for a
/// decision.
fn agrees(
    scene: &Scene,
    equations: &Equations,
    tape: &NamedTape,
    (sample, expected): (&Sample, &Expected<Wide>),
    scales: &[Vec<f64>],
) -> Result<bool, String> {
    let evaluation: Evaluation<DoubleDouble> = sample.evaluation(scene, tape, &[]);
    let errors = Errors::new(scene, equations, tape, sample);
    let largest = largest(expected, scales).max(largest_constant(scene));
    let mut all_compared = true;
    for (place, ((function, expected), scales)) in expected.iter().zip(scales).enumerate() {
        let got = evaluation.results(function);
        let own = scales.iter().fold(0.0, |most: f64, &scale| most.max(scale));
        let floor = (SMALLEST * own.max(largest)).max(TINY);
        let strict = |i: usize| (TOLERANCE * size(expected[i]).max(1e-3 * scales[i])).max(floor);
        let allowed = |i: usize| {
            let difference = size(Wide(got[i]) - expected[i]);
            if difference <= strict(i) { strict(i) } else { errors.rounding_error(place, i, expected[i], got[i]) }
        };
        let Err((i, difference)) = compare(function, &got, expected, allowed) else { continue };
        if got.len() != expected.len() || !errors.may_be_rounding(place, i, expected[i], got[i]) {
            return Err(format!("generated `{function}` is wrong: {difference}"));
        }
        all_compared = false;
    }
    Ok(all_compared)
}

/// Reports the first number that differs by more than allowed.
fn compare(
    what: &str,
    got: &[DoubleDouble],
    expected: &[Wide],
    allowed: impl Fn(usize) -> f64,
) -> Result<(), (usize, String)> {
    if got.len() != expected.len() {
        let lengths = format!("{} numbers instead of {}", got.len(), expected.len());
        return Err((0, format!("`{what}` has {lengths}")));
    }
    for (i, (got, expected)) in got.iter().zip(expected).enumerate() {
        // Written so that a difference that is not a number counts.
        if !(size(Wide(*got) - *expected) <= allowed(i)) {
            return Err((i, format!("number {i} is {:e} instead of {:e}", got.hi(), expected.0.hi())));
        }
    }
    Ok(())
}

/// Compares numbers that are computed by the same operations.
fn same(what: &str, got: &[DoubleDouble], expected: &[Wide]) -> Result<(), String> {
    let allowed = |i: usize| (TOLERANCE * size(expected[i])).max(TINY);
    compare(what, got, expected, allowed)
        .map_err(|(_, difference)| format!("generated `{what}` is wrong: {difference}"))
}

/// Verifies start, schedule and stop condition, for the scene's own parameters and at a random state.
fn verify_plain(scene: &Scene, tape: &NamedTape) -> Result<(), String> {
    let parameters: Vec<Wide> = parameter_values(scene, |_| None);
    let constant = |value: &Formula| constant(value, &parameters);
    let kept = scene.parameters.iter().zip(&parameters).filter(|(p, _)| !p.left_out);
    let (names, kept): (Vec<&str>, Vec<DoubleDouble>) = kept.map(|(p, value)| (&*p.name, value.0)).unzip();
    for ((name, value), got) in names.iter().zip(&kept).zip(Evaluation::parameters(tape, |_| None)) {
        same(&format!("value of parameter {name}"), &[got], &[Wide(*value)])?;
    }
    let starts = |start: fn(&Coordinate) -> &Start| -> Vec<Wide> {
        let value = |coordinate| match start(coordinate) {
            Start::Given(value) | Start::Guess(value) => constant(value),
            Start::Free => Wide::from(0.0),
        };
        scene.coordinates.iter().map(value).collect()
    };
    let evaluation = Evaluation::new(tape, &kept, &[]);
    same("start", &evaluation.results("start.q"), &starts(|c| &c.position))?;
    same("start", &evaluation.results("start.qd"), &starts(|c| &c.rate))?;
    same("schedule", &evaluation.results("schedule.step"), &[constant(&scene.run.step)])?;
    same("schedule", &evaluation.results("schedule.end_time"), &[constant(&scene.run.end_time)])?;
    if let Some(condition) = &scene.run.until {
        let own: Vec<f64> = parameters.iter().map(|parameter| parameter.0.hi()).collect();
        let mut random = fastrand::Rng::with_seed(2);
        for number in 0..MAX_INVALID_RATIO {
            let sample = Sample { parameters: own.clone(), ..Sample::random(scene, number, &mut random) };
            let wide = sample.on::<Wide>();
            let state = State::plain(scene, &own, wide.t, &wide.q, &wide.qd);
            let evaluation: Evaluation<DoubleDouble> = sample.evaluation(scene, tape, &[]);
            let result = |function: &str, i: usize| Wide(evaluation.results(function)[i]);
            let difference = evaluate(&condition.difference, |quantity| match *quantity {
                Quantity::Acceleration(i) => Wide(sample.qdd[i].into()),
                Quantity::Multiplier(i) => Wide(sample.multipliers[i].into()),
                Quantity::Output(i) => result("outputs", i),
                Quantity::KineticEnergy => result("energy", 0),
                Quantity::PotentialEnergy => result("energy", 1),
                Quantity::Energy => result("energy", 0) + result("energy", 1),
                quantity => state.quantity(quantity),
            });
            let expected = difference * condition.comparison.sign();
            if size(expected).is_finite() {
                same("event", &evaluation.results("event"), &[expected])?;
            }
        }
    }
    Ok(())
}
