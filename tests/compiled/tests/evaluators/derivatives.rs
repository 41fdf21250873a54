//! Derivatives by dual numbers, against functions that are derivatives of others and against difference quotients of
//! double-double numbers, at states of every scene.

use num_dual::Dual64;
use qrm_core::{Angles, DoubleDouble, Dual, Equations, Generated, Kernel, Scalar, Tape, TapeEvaluator};

use super::list::{State, WELL_CONDITIONED_GROWTH, by_tape, function, solved};
use super::number::{Number, dual};
use super::{is_random, parameter_values, states};

type D = Dual<Dual64>;

/// Largest difference relative to the largest number of a function.
const TOLERANCE: f64 = 1e-11;

fn assert_near(what: &str, got: &[f64], expected: &[f64]) {
    let largest = expected.iter().fold(1.0_f64, |most, value| most.max(value.abs()));
    assert_eq!(got.len(), expected.len(), "{what}");
    for (got, expected) in got.iter().zip(expected) {
        assert!((got - expected).abs() <= TOLERANCE * largest, "{what}: {got:e} instead of {expected:e}");
    }
}

/// Time, coordinates and rates with derivatives by one variable.
struct Seeded<const N: usize> {
    t: D,
    q: [D; N],
    qd: [D; N],
}

/// The direction of a derivative: a variable, or the motion.
#[derive(Clone, Copy, PartialEq)]
enum By {
    Time,
    Coordinate(usize),
    Rate(usize),
    /// The state moves with its rates.
    Motion,
}

impl<const N: usize> Seeded<N> {
    fn new<const M: usize>(state: &State<N, M>, by: By) -> Self {
        let moves = by == By::Motion;
        let unit = |is_one: bool| f64::from(u8::from(is_one));
        let of_q = |i: usize| if moves { state.qd[i] } else { unit(by == By::Coordinate(i)) };
        Self {
            t: dual(state.t, unit(moves || by == By::Time)),
            q: std::array::from_fn(|i| dual(state.q[i], of_q(i))),
            qd: std::array::from_fn(|i| dual(state.qd[i], unit(by == By::Rate(i)))),
        }
    }
}

fn derivatives(values: &[D]) -> Vec<f64> {
    values.iter().map(|value| value.0.eps).collect()
}

/// `Mbar qdd + C_q' lambda - fbar` and `C_q qdd + bias` with accelerations and multipliers held.
fn residuals<const N: usize, const M: usize>(tape: &Tape, dynamics: &[D], state: &State<N, M>) -> Vec<D> {
    let [mass, forces, jacobian, bias] = tape.split_dynamics(dynamics);
    let times = |x: D, y: f64| x * D::from_f64(y);
    let along = |row: &[D]| row.iter().zip(&state.qdd).fold(D::zero(), |sum, (x, a)| sum + times(*x, *a));
    let pull = |i: usize| (0..M).fold(D::zero(), |sum, k| sum + times(jacobian[k * N + i], state.multipliers[k]));
    let of_motion = (0..N).map(|i| along(&mass[i * N..][..N]) + pull(i) - forces[i]);
    of_motion.chain((0..M).map(|k| along(&jacobian[k * N..][..N]) + bias[k])).collect()
}

/// Compares derivatives by the state.
fn by_state<const N: usize, const M: usize>(tape: &Tape, values: &[f64], state: &State<N, M>) {
    let known = by_tape(tape, values, state);
    if known.iter().flat_map(|(_, numbers)| numbers).any(|number| !number.is_finite()) {
        return;
    }
    let mut evaluator = TapeEvaluator::<Vec<D>>::with_parameters(tape, values);
    let mut closed = vec![D::zero(); tape.loop_constraints.results.len()];
    let mut dynamics = vec![D::zero(); tape.dynamics_length()];

    let Seeded { t, q, .. } = Seeded::new(state, By::Time);
    evaluator.loop_constraints(t, &q, &mut closed);
    let [constraints, ..] = tape.split_loop_constraints(&closed);
    assert_near("C_t", &derivatives(constraints), function(&known, "rate"));

    let Seeded { t, q, qd } = Seeded::new(state, By::Motion);
    evaluator.loop_constraints(t, &q, &mut closed);
    let [constraints, jacobian, rate] = tape.split_loop_constraints(&closed);
    assert_near("velocity residual", &derivatives(constraints), function(&known, "velocity residual"));
    let along = |k: usize| (0..N).fold(rate[k], |sum, i| sum + jacobian[k * N + i] * qd[i]);
    let velocity_residual: Vec<D> = (0..M).map(along).collect();
    assert_near("bias", &derivatives(&velocity_residual), function(&known, "bias"));

    for i in 0..N {
        let Seeded { t, q, .. } = Seeded::new(state, By::Coordinate(i));
        evaluator.loop_constraints(t, &q, &mut closed);
        let [constraints, ..] = tape.split_loop_constraints(&closed);
        let column: Vec<f64> = function(&known, "jacobian").chunks(N).map(|row| row[i]).collect();
        assert_near("C_q", &derivatives(constraints), &column);
        let Seeded { q, qd, .. } = Seeded::new(state, By::Rate(i));
        let momentum: f64 = (0..N).map(|j| function(&known, "mass matrix")[i * N + j] * state.qd[j]).sum();
        assert_near("Mbar qd", &derivatives(&evaluator.energy(&q, &qd)), &[momentum, 0.0]);
    }

    let linearization = function(&known, "linearization");
    if linearization.is_empty() {
        return;
    }
    let mut of_equations = |by: By| {
        let Seeded { t, q, qd } = Seeded::new(state, by);
        evaluator.dynamics(t, &q, &qd, &mut dynamics);
        derivatives(&residuals(tape, &dynamics, state))
    };
    let [stiffness, damping, of_loops, of_loop_rates, forcing, loop_forcing] = tape.split_linearization(linearization);
    let column = |matrix: &[f64], i: usize| matrix.chunks(N).map(|row| row[i]).collect::<Vec<f64>>();
    for i in 0..N {
        let expected = [column(stiffness, i), column(of_loops, i)].concat();
        assert_near("stiffness", &of_equations(By::Coordinate(i)), &expected);
        assert_near("damping", &of_equations(By::Rate(i)), &[column(damping, i), column(of_loop_rates, i)].concat());
    }
    let forcing: Vec<f64> = forcing.iter().chain(loop_forcing).map(|force| -force).collect();
    assert_near("forcing", &of_equations(By::Time), &forcing);
}

/// Accelerations and multipliers on a tape whose parameters have these values.
fn motion<R: Number, const N: usize, const M: usize>(tape: &Tape, values: &[R], state: &State<N, M>) -> Option<Vec<R>> {
    let of_motion = solved(&by_tape(tape, values, state), state)?;
    Some([function(&of_motion, "accelerations"), function(&of_motion, "multipliers")].concat())
}

/// Compares derivatives of accelerations and multipliers by each parameter: by kernel, by tape, by differences.
fn by_parameters<X: Generated<N, M>, const N: usize, const M: usize>(values: &[f64], state: &State<N, M>) -> bool {
    let tape = X::TAPE.tape();
    for i in 0..values.len() {
        let seeded: Vec<D> = values.iter().enumerate().map(|(j, &v)| dual(v, f64::from(u8::from(i == j)))).collect();
        let kernel = X::Kernel::<D>::with_values(&|j| seeded[j]);
        let (t, q, qd) = (D::from_f64(state.t), state.q.map(D::from_f64), state.qd.map(D::from_f64));
        let angles = Angles::new(&q, kernel.has_angle());
        let position = kernel.position(t, &q, &angles);
        if !(kernel.growth_factor(&position).0.re < WELL_CONDITIONED_GROWTH) {
            return false;
        }
        let (qdd, multipliers) = kernel.accelerations(&position, t, &q, &qd, &angles);
        let by_kernel = derivatives(&[&qdd[..], &multipliers].concat());
        // Relative to the parameter, truncation errors are of the size of h^2, rounding errors of 1e-32 over h.
        let h = DoubleDouble::from(1e-10 * if values[i] == 0.0 { 1.0 } else { values[i].abs() });
        let moved = |by: DoubleDouble| {
            let mut values: Vec<DoubleDouble> = values.iter().map(|&value| value.into()).collect();
            values[i] = values[i] + by;
            motion(tape, &values, state)
        };
        let (Some(up), Some(down)) = (moved(h), moved(-h)) else { return false };
        let slope = |(up, down): (&DoubleDouble, &DoubleDouble)| ((*up - *down) / (h + h)).hi();
        let differences: Vec<f64> = up.iter().zip(&down).map(slope).collect();
        assert_near("by parameter", &by_kernel, &differences);
    }
    true
}

/// Compares derivatives of a mechanism.
fn differentiated<X: Generated<N, M>, const N: usize, const M: usize>() {
    // Differences say too little where much cancels.
    if is_random::<X, N, M>() {
        return;
    }
    let values = parameter_values::<X, N, M>();
    let mut compared = 0;
    for (number, state) in states::<X, N, M>(&values).enumerate() {
        by_state(X::TAPE.tape(), &values, &state);
        compared += usize::from(number < 50 && by_parameters::<X, N, M>(&values, &state));
    }
    assert!(compared > 20, "{}: derivatives by parameters at {compared} states", X::DESCRIPTION.name);
}

#[test]
fn dual_numbers_give_derivatives() {
    super::for_all_scenes!(differentiated);
}
