//! Every evaluator of a mechanism's functions gives the values of the tape on double-double numbers, within
//! rounding errors that the tape on numbers with error bounds allows: at 1000 random states of every scene.

#[macro_use]
#[path = "../../common/delegate.rs"]
mod delegate;
mod bounded;
mod derivatives;
mod hand;
mod lanes;
mod list;
mod number;

#[allow(dead_code, unreachable_pub, unused_imports, reason = "the benchmarks use the rest")]
#[path = "../../../benches/twin/mod.rs"]
mod twin;

use qrm_core::{DoubleDouble, Equations, Generated, Mechanism, Scalar, StartMut, Tape, TapeEvaluator};
use qrm_sim::position::{Start, assemble};

use crate::model;
use bounded::Bounded;
use list::{OUTPUTS_AT, State, Values, by_tape, evaluators, solved};
use twin::{ByHand, HandWritten, Twin};

const STATES: usize = 1000;
/// Errors of linear equations that are solved in doubles, relative to the largest number.
const SOLVED: f64 = 1e-11;

/// Calls a function `f::<X, N, M>()` for every scene, in the order of `qrm_model::MODELS`.
macro_rules! for_all_scenes {
    ($f:ident) => {
        $crate::evaluators::for_all_scenes!($f:
            andrews::Andrews, 7, 6;
            double_pendulum::DoublePendulum, 2, 0;
            four_bar::FourBar, 3, 2;
            n_four_bar_2::NFourBar2, 5, 4;
            pendulum::Pendulum, 2, 1;
            quick_return_driven::QuickReturnDriven, 3, 3;
            quick_return_loaded::QuickReturnLoaded, 3, 2;
            quick_return::QuickReturn, 3, 2;
            shaper::Shaper, 3, 2;
            slider_crank::SliderCrank, 3, 2;
            thrown_stick::ThrownStick, 3, 0;
        )
    };
    ($f:ident: $($module:ident::$scene:ident, $n:literal, $m:literal;)*) => {
        [$($f::<qrm_model::$module::$scene, $n, $m>()),*]
    };
}

pub(crate) use for_all_scenes;

/// The scene's values of the parameters.
fn parameter_values<X: Generated<N, M>, const N: usize, const M: usize>() -> Vec<f64> {
    model(X::DESCRIPTION.name).parameter_values(&|_| None)
}

/// Random states around the start, among them such that no loop is closed.
fn states<X: Generated<N, M>, const N: usize, const M: usize>(parameters: &[f64]) -> impl Iterator<Item = State<N, M>> {
    let start = X::Kernel::<f64>::with_values(&|i| parameters[i]).start();
    let mut random = fastrand::Rng::with_seed(11);
    std::iter::repeat_with(move || {
        let mut near = |x: f64| x + 2.0 * (random.f64() - 0.5);
        State {
            t: near(1.0),
            q: start.q.map(&mut near),
            qd: start.qd.map(|v| near(v) + 3.0 * near(0.0)),
            qdd: [0.0; N].map(|a| 20.0 * near(a)),
            multipliers: [0.0; M].map(|lambda| 100.0 * near(lambda)),
            residuals: std::array::from_fn(|k| 0.01 * (k as f64 + 1.0)),
        }
    })
    .take(STATES)
}

/// The values of functions and how far doubles may be from them.
type Reference = Vec<(&'static str, Vec<(DoubleDouble, f64)>)>;

/// By the tape on double-double numbers; `None` where a formula has no value.
fn reference<const N: usize, const M: usize>(
    tape: &Tape,
    parameters: &[f64],
    state: &State<N, M>,
) -> Option<Reference> {
    let exact: Vec<DoubleDouble> = parameters.iter().map(|&p| p.into()).collect();
    let bounded: Vec<Bounded> = parameters.iter().map(|&p| Bounded::from_f64(p)).collect();
    let (exact, bounded) = (by_tape(tape, &exact, state), by_tape(tape, &bounded, state));
    let of_motion = solved(&exact, state)?;
    // Bounds are no larger than what cancels explains; of random scenes very much may.
    let is_known = exact.iter().zip(&bounded).all(|((_, exact), (_, bounded))| {
        let largest = exact.iter().fold(0.0, |most: f64, number| most.max(number.hi().abs()));
        bounded.iter().all(|b| !(b.error > 1e-9 * largest.max(1e3)))
    });
    if !is_known {
        return None;
    }
    let functions = exact.into_iter().zip(bounded).map(|((name, exact), (_, bounded))| {
        (name, exact.into_iter().zip(bounded).map(|(exact, bounded)| (exact, bounded.error)).collect())
    });
    let of_motion = of_motion.into_iter().map(|(name, exact)| {
        let largest = exact.iter().fold(1.0, |most: f64, number| most.max(number.hi().abs()));
        (name, exact.into_iter().map(|exact| (exact, SOLVED * largest)).collect())
    });
    let mut reference: Reference = functions.chain(of_motion).collect();
    let outputs = reference.iter().find(|(name, _)| *name == "outputs").map(|(_, outputs)| outputs.clone());
    reference.push((OUTPUTS_AT, outputs.expect("a function of the tape")));
    reference.iter().flat_map(|(_, numbers)| numbers).all(|(exact, _)| exact.hi().is_finite()).then_some(reference)
}

/// Compares the functions of an evaluator; the largest difference as a part of what is allowed.
fn compare(what: &str, got: &Values<DoubleDouble>, reference: &Reference, errors: f64) -> f64 {
    let mut worst = 0.0_f64;
    for (name, got) in got {
        let (_, exact) = reference.iter().find(|(n, _)| n == name).expect("a function of the tape");
        assert_eq!(got.len(), exact.len(), "{what}: {name}");
        for (got, (exact, error)) in got.iter().zip(exact) {
            let difference = (*got - *exact).abs().hi();
            assert!(difference <= errors * error, "{what}: {name} is {got:?} instead of {exact:?}, {error:e}");
            worst = worst.max(if difference == 0.0 { 0.0 } else { difference / (errors * error) });
        }
    }
    worst
}

/// Whether a scene is one of the random mechanisms of `.ci/random-mechanisms`.
fn is_random<X: Generated<N, M>, const N: usize, const M: usize>() -> bool {
    X::DESCRIPTION.name.starts_with("random-")
}

/// Whether the kernel suits the start: not where constraints repeat others.
fn has_kernel<X: Generated<N, M>, const N: usize, const M: usize>() -> bool {
    let mechanism = model(X::DESCRIPTION.name).mechanism(&|_| None);
    !is_random::<X, N, M>()
        || assemble(&*mechanism, Start::new(&*mechanism)).is_ok_and(|(q, qd)| {
            let (mut qdd, mut multipliers) = (qd.clone(), vec![0.0; M]);
            mechanism.accelerations(0.0, &q, &qd, &mut qdd, &mut multipliers)
        })
}

/// Compares all evaluators of a mechanism, with tape and kernel of `X`.
fn battery<X: Generated<N, M>, const N: usize, const M: usize>(mechanism: &dyn Mechanism, is_generated: bool) {
    let tape = X::TAPE.tape();
    let parameters = mechanism.parameters();
    let evaluators = evaluators::<X, N, M>();
    let mut compared = [0; 11];
    let mut worst = [0.0_f64; 11];
    for state in states::<X, N, M>(parameters) {
        let Some(reference) = reference(tape, parameters, &state) else { continue };
        let mut of_doubles: Vec<Values<DoubleDouble>> = Vec::new();
        for (i, evaluator) in evaluators.iter().enumerate() {
            let Some(mut values) = evaluator.values(mechanism, tape, &state) else { continue };
            if !is_generated {
                values.retain(|(name, _)| *name != OUTPUTS_AT);
            }
            let what = format!("{}, {}", X::DESCRIPTION.name, evaluator.name);
            worst[i] = worst[i].max(compare(&what, &values, &reference, evaluator.errors));
            compared[i] += 1;
            if ["plain functions", "tape on f64"].contains(&evaluator.name) {
                values.sort_by_key(|(name, _)| *name);
                of_doubles.push(values);
            }
        }
        if is_generated {
            assert_eq!(of_doubles[0], of_doubles[1], "{}: the same operations", X::DESCRIPTION.name);
        }
    }
    for ((evaluator, compared), worst) in evaluators.iter().zip(compared).zip(worst) {
        println!("{:20} {:32} {compared:4} states, {worst:.1e} of the bound", X::DESCRIPTION.name, evaluator.name);
        let is_enough = compared > if is_random::<X, N, M>() { 0 } else { 900 } || !has_kernel::<X, N, M>();
        assert!(is_enough, "{}, {}: {compared} states", X::DESCRIPTION.name, evaluator.name);
    }
}

/// Compares all evaluators of a scene; its name.
fn scene<X: Generated<N, M>, const N: usize, const M: usize>() -> &'static str {
    let mechanism = model(X::DESCRIPTION.name).mechanism(&|_| None);
    battery::<X, N, M>(&*mechanism, true);
    let mut evaluator = TapeEvaluator::<Vec<f64>>::new(X::TAPE.tape());
    let (mut q, mut qd, mut given, mut given_rates) = ([0.0; N], [0.0; N], [false; N], [false; N]);
    mechanism.start(StartMut { q: &mut q, given: &mut given, qd: &mut qd, given_rates: &mut given_rates });
    let (mut tape_q, mut tape_qd) = ([0.0; N], [0.0; N]);
    evaluator.start(&mut tape_q, &mut tape_qd);
    assert_eq!(evaluator.parameters(), mechanism.parameters());
    assert_eq!(parameter_values::<X, N, M>(), mechanism.parameters());
    assert_eq!((tape_q, tape_qd, evaluator.schedule()), (q, qd, mechanism.schedule()));
    assert_eq!(X::TAPE.tape().given, [given, given_rates].concat());
    X::DESCRIPTION.name
}

#[test]
fn evaluators_agree() {
    let names: Vec<&str> = qrm_model::MODELS.iter().map(|model| model.description.name).collect();
    assert_eq!(for_all_scenes!(scene)[..], names);
}

#[test]
fn the_twin_by_hand_agrees() {
    battery::<HandWritten, 3, 2>(&Twin::<ByHand>::new(), false);
}
