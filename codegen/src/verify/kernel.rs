//! Compares the kernel of a tape with the equations of motion as one system, solved by elimination with pivoting.

use num_traits::Signed;
use qrm_core::{DoubleDouble, MAX_GROWTH, NamedTape, Scalar};

use super::errors::{CONSTANTS, Errors};
use super::evaluation::Evaluation;
use super::expected::Expected;
use super::sample::Sample;
use super::size::{TINY, size};
use super::system::System;
use super::wide::Wide;
use crate::term::Equations;
use qrm_scene::scene::Scene;

/// Largest difference of a number, relative to itself.
const TOLERANCE: f64 = 1e-12;
/// The largest difference, relative to the change caused by the last digits of the sample.
const SPREAD: f64 = 10.0;
/// Rounding errors with 32 digits, relative to the cancelling terms.
const ROUNDING: f64 = 1e-26;

/// Compares every function of the kernel at a state, if it is valid at the position and the equations are not nearly
/// singular there.
pub(super) fn agrees(
    scene: &Scene,
    equations: &Equations,
    tape: &NamedTape,
    (sample, expected): (&Sample, &Expected<Wide>),
) -> Result<(), String> {
    let opened: Vec<f64> = (0..scene.constraints.len()).map(|k| 0.1 * (k as f64 + 1.0)).collect();
    let evaluation: Evaluation<DoubleDouble> = sample.evaluation(scene, tape, &opened);
    let growth_factor = evaluation.results("growth_factor");
    if equations.has_momenta() {
        return is_balanced(scene, equations, sample, &evaluation);
    }
    let known = |name: &str| numbers(expected, name);
    let system = System::new(known("mass_matrix"), known("dynamics.constraint_jacobian"), sample.q.len());
    let constraints = known("loop_constraints.residuals");

    let rates =
        system.velocity_residual(&sample.on::<Wide>().qd).into_iter().zip(known("loop_constraints.constraint_rate"));
    let rates: Vec<Wide> = rates.map(|(along, own)| along + own).collect();
    let errors = Errors::new(scene, equations, tape, sample);
    let compare = |name: &str, got: &[DoubleDouble], expected: &[Wide]| {
        let largest = expected.iter().map(|number| size(*number)).fold(0.0, f64::max);
        let allowed = (TOLERANCE * largest).max(sample.error_of_zeros(largest));
        compare_all(name, got, expected, |_| allowed).or_else(|_| {
            let constant_error = |i: usize| errors.constant_error(&format!("loop_constraints.{name}"), i);
            compare_all(name, got, expected, |i| allowed.max(constant_error(i)))
        })
    };
    compare("residuals", &evaluation.results("residuals"), constraints)?;
    compare("velocity_residual", &evaluation.results("velocity_residual"), &rates)?;
    if !growth_factor.iter().all(|growth_factor| growth_factor.is_within(MAX_GROWTH)) {
        return Ok(());
    }
    let bias: Vec<Wide> = known("dynamics.constraint_bias").iter().map(|bias| -*bias).collect();
    let closing: Vec<Wide> = opened.iter().map(|&r| Wide::from(-r)).collect();
    let none = vec![Wide::from(0.0); sample.q.len()];
    let forces = known("dynamics.generalized_forces");
    let (Some((accelerations, growth)), Some((correction, _))) =
        (system.solve(forces, &bias), system.solve(&none, &closing))
    else {
        return Ok(());
    };
    let n = sample.q.len();
    // The sensitivity of the solutions to the last digits of the sample, and the rounding errors where forces cancel.
    let here = &system;
    let spreads = || {
        let nearby = sample.nearby().on::<Wide>().expected(scene, equations)?;
        let known = |name: &str| numbers(&nearby, name);
        let system = System::new(known("mass_matrix"), known("dynamics.constraint_jacobian"), n);
        let bias: Vec<Wide> = known("dynamics.constraint_bias").iter().map(|bias| -*bias).collect();
        let (moved, _) = system.solve(known("dynamics.generalized_forces"), &bias)?;
        let (moved_correction, _) = system.solve(&none, &closing)?;
        // Terms cancel in matrix entries too; double-precision rounding errors show their size.
        let samples = [(sample, expected), (&sample.nearby(), &nearby)];
        let sizes = |name: &str| -> Option<Vec<Wide>> {
            let mut sizes: Vec<Wide> = known(name).iter().map(Signed::abs).collect();
            for (at, exact) in samples {
                let rounded = at.expected(scene, equations)?;
                let pairs = numbers(&rounded, name).iter().zip(numbers(exact, name));
                for (size_of_terms, (rounded, exact)) in sizes.iter_mut().zip(pairs) {
                    *size_of_terms += Wide::from(size(Wide::from(*rounded) - *exact) / f64::EPSILON);
                }
            }
            Some(sizes)
        };
        let terms = System::new(&sizes("mass_matrix")?, &sizes("dynamics.constraint_jacobian")?, n);
        let (force_sizes, bias_sizes) =
            (sample.on::<Wide>().force_sizes(scene, equations), sizes("dynamics.constraint_bias")?);
        let (of_terms, _) = system.solve(&force_sizes, &bias_sizes)?;
        let rounding = ROUNDING * growth * of_terms.into_iter().map(size).fold(0.0, f64::max);
        // Numbers in the text of a module have 16 digits.
        let constant_error = |x: &[Wide], right: [&[Wide]; 2]| -> Option<Vec<f64>> {
            let bound = here.error_bound(&terms, x, &right.concat())?;
            Some(bound.into_iter().map(|bound| CONSTANTS * f64::EPSILON * bound).collect())
        };
        let spread = |moved: Vec<Wide>, from: &[Wide], constant_error: Vec<f64>| -> Vec<f64> {
            let both = moved.iter().zip(from).zip(constant_error);
            both.map(|((moved, from), error)| SPREAD * size(*moved - *from) + error + rounding).collect()
        };
        Some([
            spread(moved, &accelerations, constant_error(&accelerations, [&force_sizes, &bias_sizes])?),
            spread(moved_correction, &correction, constant_error(&correction, [&none, &closing])?),
        ])
    };
    let compare = |name: &str, got: &[DoubleDouble], expected: &[Wide], which: usize| {
        let allowed = |i: usize| (TOLERANCE * size(expected[i])).max(sample.error_of_zeros(size(expected[i])));
        compare_all(name, got, expected, allowed).or_else(|wrong| {
            let spreads = spreads().ok_or(wrong)?;
            compare_all(name, got, expected, |i| allowed(i) + spreads[which][i])
        })
    };
    if tape.function("inverse_dynamics").is_some() {
        inverse_dynamics(tape, &evaluation, (sample, expected))?;
    }
    compare("accelerations", &evaluation.results("accelerations"), &accelerations, 0)?;
    compare("correction", &evaluation.results("correction"), &correction[..n], 1)
}

/// Checks that the accelerations of a large tree balance its forces in every row of the equations of motion, if the
/// kernel is valid at the position.
fn is_balanced(
    scene: &Scene,
    equations: &Equations,
    sample: &Sample,
    evaluation: &Evaluation<DoubleDouble>,
) -> Result<(), String> {
    if !evaluation.results("growth_factor").iter().all(|growth_factor| growth_factor.is_within(MAX_GROWTH)) {
        return Ok(());
    }
    let accelerations: Vec<Wide> = evaluation.results("accelerations").into_iter().map(Wide).collect();
    let balance = sample.on::<Wide>().balance(scene, equations, &accelerations);
    for (i, (rest, terms)) in balance.into_iter().enumerate() {
        check_row("accelerations", i, sample, size(rest), size(terms))?;
    }
    let still = vec![Wide::from(0.0); accelerations.len()];
    compare_all("correction", &evaluation.results("correction"), &still, |_| 0.0)
}

/// Checks that what remains of a row of the equations of motion is a rounding error, relative to the size of its terms.
fn check_row(function: &str, i: usize, sample: &Sample, rest: f64, size_of_terms: f64) -> Result<(), String> {
    // Written so that a remainder that is not a number counts.
    if !(rest <= (TOLERANCE * size_of_terms.max(TINY)).max(sample.error_of_zeros(size_of_terms))) {
        return Err(format!("generated `{function}` is wrong: row {i} does not balance, by {rest:e}"));
    }
    Ok(())
}

/// Checks that forces and multipliers balance accelerations and loads in every row of the equations of motion.
fn inverse_dynamics(
    tape: &NamedTape,
    evaluation: &Evaluation<DoubleDouble>,
    (sample, expected): (&Sample, &Expected<Wide>),
) -> Result<(), String> {
    let result = evaluation.results("inverse_dynamics");
    let (forces, multipliers) = result.split_at(tape.actuated.len());
    let [mass, jacobian, loads] = ["mass_matrix", "dynamics.constraint_jacobian", "dynamics.generalized_forces"]
        .map(|name| numbers(expected, name));
    let n = sample.q.len();
    let accelerations = &sample.on::<Wide>().qdd;
    for i in 0..n {
        let inertia = (0..n).map(|j| mass[i * n + j] * accelerations[j]);
        let loops = multipliers.iter().enumerate().map(|(k, lambda)| jacobian[k * n + i] * Wide(*lambda));
        let own = tape.actuated.iter().position(|place| *place == i).map(|place| -Wide(forces[place]));
        let terms: Vec<Wide> = inertia.chain(loops).chain(own).chain([-loads[i]]).collect();
        let rest = size(terms.iter().copied().sum());
        let largest = terms.iter().fold(0.0, |most: f64, term| most.max(size(*term)));
        check_row("inverse_dynamics", i, sample, rest, largest)?;
    }
    Ok(())
}

/// The numbers of one function; empty if it is missing.
fn numbers<'e, B>(expected: &'e Expected<B>, name: &str) -> &'e [B] {
    expected.iter().find(|(other, _)| *other == name).map_or(&[], |(_, numbers)| numbers)
}

fn compare_all(
    name: &str,
    got: &[DoubleDouble],
    expected: &[Wide],
    allowed: impl Fn(usize) -> f64,
) -> Result<(), String> {
    let allowed = |i: usize| allowed(i).max(TINY);
    super::compare(name, got, expected, allowed).map_err(|(_, what)| format!("generated `{name}` is wrong: {what}"))
}
