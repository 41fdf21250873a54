//! Every evaluator of a mechanism's functions.

use num_dual::Dual64;
use qrm_core::{
    Angles, DoubleDouble, Dual, DynamicsMut, Equations, Fused, Generated, Kernel, LinearizationMut, LoopConstraintsMut,
    Mechanism, StateRef, Tape, TapeEvaluator,
};
use qrm_sim::solve::{Dynamics, Ldl, Linearization, LoopConstraints, Projection, ProjectionTolerance, Solver, dot};

use super::lanes::Lanes;
use super::number::{Number, solve};

/// A state, with accelerations and multipliers for the functions of them and residuals to be corrected.
#[derive(Clone, Copy, Debug)]
pub(crate) struct State<const N: usize, const M: usize> {
    pub(crate) t: f64,
    pub(crate) q: [f64; N],
    pub(crate) qd: [f64; N],
    pub(crate) qdd: [f64; N],
    pub(crate) multipliers: [f64; M],
    pub(crate) residuals: [f64; M],
}

/// The values of functions.
pub(crate) type Values<R> = Vec<(&'static str, Vec<R>)>;

/// One way to the values of functions, and how many times as large as those of the tape its rounding errors may be.
pub(crate) struct Evaluator<const N: usize, const M: usize> {
    pub(crate) name: &'static str,
    pub(crate) errors: f64,
    evaluate: fn(&dyn Mechanism, &Tape, &State<N, M>) -> Option<Values<DoubleDouble>>,
}

impl<const N: usize, const M: usize> Evaluator<N, M> {
    /// The functions that it has; `None` where it does not suit the state.
    pub(crate) fn values(
        &self,
        mechanism: &dyn Mechanism,
        tape: &Tape,
        state: &State<N, M>,
    ) -> Option<Values<DoubleDouble>> {
        (self.evaluate)(mechanism, tape, state)
    }
}

/// The list of them, with the kernel of `X`.
pub(crate) fn evaluators<X: Generated<N, M>, const N: usize, const M: usize>() -> [Evaluator<N, M>; 11] {
    let evaluator = |name, errors, evaluate| Evaluator { name, errors, evaluate };
    [
        evaluator("plain functions", 1.0, |x, _, state| Some(plain(x, state))),
        evaluator("solver of the simulator", 1.0, |x, _, state| solver(x, state)),
        evaluator("tape on f64", 1.0, tape::<f64, N, M>),
        evaluator("tape on Fused", 1.0, tape::<Fused, N, M>),
        evaluator("tape on lanes", 1.0, tape::<Lanes, N, M>),
        evaluator("tape on dual numbers", 1.0, tape::<Dual<Dual64>, N, M>),
        evaluator("kernel on f64", KERNEL, kernel::<X, f64, N, M>),
        evaluator("kernel on Fused", KERNEL, kernel::<X, Fused, N, M>),
        evaluator("kernel on lanes", KERNEL, kernel::<X, Lanes, N, M>),
        evaluator("kernel on dual numbers", KERNEL, kernel::<X, Dual<Dual64>, N, M>),
        evaluator("kernel on double-double numbers", KERNEL * 1e-15, kernel::<X, DoubleDouble, N, M>),
    ]
}

/// A kernel has other formulae, whose terms may be larger.
const KERNEL: f64 = 50.0;

/// All functions by the tape of a mechanism with these parameters.
pub(crate) fn by_tape<R: Number, const N: usize, const M: usize>(
    tape: &Tape,
    parameters: &[R],
    state: &State<N, M>,
) -> Values<R> {
    let input = |values: &[f64]| -> Vec<R> { values.iter().map(|&value| R::input(value)).collect() };
    let (t, q, qd) = (R::input(state.t), input(&state.q), input(&state.qd));
    let (qdd, multipliers) = (input(&state.qdd), input(&state.multipliers));
    let mut evaluator = TapeEvaluator::new(tape);
    evaluator.set_parameters(|i| Some(parameters[i]));
    let room = |function: &qrm_core::TapeFunction| vec![R::zero(); function.results.len()];
    let (mut dynamics, mut closed) = (room(&tape.dynamics), room(&tape.loop_constraints));
    let (mut mass, mut outputs) = (room(&tape.mass_matrix), room(&tape.outputs));
    evaluator.dynamics(t, &q, &qd, &mut dynamics);
    evaluator.loop_constraints(t, &q, &mut closed);
    evaluator.mass_matrix(&q, &mut mass);
    evaluator.outputs(t, &q, &qd, &qdd, &multipliers, &mut outputs);
    let [of_dynamics, forces, jacobian, bias] = tape.split_dynamics(&dynamics);
    let [constraints, of_closed, rate] = tape.split_loop_constraints(&closed);
    let along = |row: &[R]| row.iter().zip(&qd).fold(R::zero(), |sum, (entry, v)| sum + *entry * *v);
    let velocity_residual = of_closed.chunks(N).zip(rate).map(|(row, rate)| along(row) + *rate).collect();
    let mut values = vec![
        ("mass matrix", mass),
        ("mass matrix of dynamics", of_dynamics.to_vec()),
        ("forces", forces.to_vec()),
        ("jacobian", jacobian.to_vec()),
        ("bias", bias.to_vec()),
        ("constraints", constraints.to_vec()),
        ("jacobian of constraints", of_closed.to_vec()),
        ("rate", rate.to_vec()),
        ("velocity residual", velocity_residual),
        ("energy", evaluator.energy(&q, &qd).to_vec()),
        ("power", vec![evaluator.power(t, &q, &qd, &qdd, &multipliers)]),
        ("outputs", outputs),
        ("event", evaluator.event(t, &q, &qd, &qdd, &multipliers).into_iter().collect()),
    ];
    if let Some(linearization) = &tape.linearization {
        let mut results = room(linearization);
        evaluator.linearization(t, &q, &qd, &qdd, &multipliers, &mut results);
        values.push(("linearization", results));
    }
    values
}

/// The values of a function.
pub(crate) fn function<'v, R>(values: &'v Values<R>, name: &str) -> &'v [R] {
    values.iter().find(|(n, _)| *n == name).map_or(&[], |(_, numbers)| numbers)
}

/// Accelerations, multipliers and correction, from the functions and the equations of motion as one system.
pub(crate) fn solved<R: Number, const N: usize, const M: usize>(
    values: &Values<R>,
    state: &State<N, M>,
) -> Option<Values<R>> {
    let (mass, jacobian) = (function(values, "mass matrix"), function(values, "jacobian"));
    let row = |i: usize| -> Vec<R> {
        match i.checked_sub(N) {
            None => [mass[i * N..][..N].to_vec(), (0..M).map(|k| jacobian[k * N + i]).collect()].concat(),
            Some(k) => [&jacobian[k * N..][..N], &vec![R::zero(); M]].concat(),
        }
    };
    let system = |right: Vec<R>| solve((0..N + M).map(row).collect(), right);
    let bias = function(values, "bias").iter().map(|bias| -*bias);
    let motion = system(function(values, "forces").iter().copied().chain(bias).collect())?;
    let residuals = state.residuals.iter().map(|&residual| R::from_f64(-residual));
    let correction = system(std::iter::repeat_n(R::zero(), N).chain(residuals).collect())?;
    Some(vec![
        ("accelerations", motion[..N].to_vec()),
        ("multipliers", motion[N..].to_vec()),
        ("correction", correction[..N].to_vec()),
    ])
}

fn in_double_double<R: Number>(values: Values<R>) -> Values<DoubleDouble> {
    let each = |(name, numbers): (_, Vec<R>)| (name, numbers.into_iter().map(Number::value).collect());
    values.into_iter().map(each).collect()
}

fn tape<R: Number, const N: usize, const M: usize>(
    mechanism: &dyn Mechanism,
    tape: &Tape,
    state: &State<N, M>,
) -> Option<Values<DoubleDouble>> {
    let parameters: Vec<R> = mechanism.parameters().iter().map(|&value| R::from_f64(value)).collect();
    Some(in_double_double(by_tape(tape, &parameters, state)))
}

fn plain<const N: usize, const M: usize>(x: &dyn Mechanism, s: &State<N, M>) -> Values<DoubleDouble> {
    let (dynamics, closed) = (Dynamics::at(x, s.t, &s.q, &s.qd), LoopConstraints::at(x, s.t, &s.q));
    let mut mass_matrix = vec![0.0; N * N];
    x.mass_matrix(&s.q, &mut mass_matrix);
    let mut outputs = vec![0.0; x.description().outputs.len()];
    x.outputs(s.t, &s.q, &s.qd, &s.qdd, &s.multipliers, &mut outputs);
    let mut values = vec![
        ("mass matrix", mass_matrix),
        ("mass matrix of dynamics", dynamics.mass_matrix.entries().to_vec()),
        ("forces", dynamics.generalized_forces),
        ("jacobian", dynamics.constraint_jacobian.entries().to_vec()),
        ("bias", dynamics.constraint_bias),
        ("velocity residual", closed.velocity_residual(&s.qd)),
        ("constraints", closed.residuals),
        ("jacobian of constraints", closed.constraint_jacobian.entries().to_vec()),
        ("rate", closed.constraint_rate),
        ("energy", x.energy(&s.q, &s.qd).to_vec()),
        ("power", vec![x.power(s.t, &s.q, &s.qd, &s.qdd, &s.multipliers)]),
        ("outputs", outputs),
        (
            "event",
            x.event(&StateRef { t: s.t, q: &s.q, qd: &s.qd, qdd: &s.qdd, multipliers: &s.multipliers })
                .into_iter()
                .collect(),
        ),
    ];
    let mut l = Linearization::zero(N, M);
    let room = LinearizationMut {
        stiffness: l.stiffness.entries_mut(),
        damping: l.damping.entries_mut(),
        constraint_stiffness: l.constraint_stiffness.entries_mut(),
        constraint_damping: l.constraint_damping.entries_mut(),
        forcing: &mut l.forcing,
        constraint_forcing: &mut l.constraint_forcing,
    };
    let is_linearized = x.linearization(s.t, &s.q, &s.qd, &s.qdd, &s.multipliers, room);
    assert_eq!(is_linearized, x.has_linearization());
    if is_linearized {
        let forces = [l.stiffness.entries(), l.damping.entries()].concat();
        let loops = [l.constraint_stiffness.entries(), l.constraint_damping.entries()].concat();
        values.push(("linearization", [&forces[..], &loops, &l.forcing, &l.constraint_forcing].concat()));
    }
    in_double_double(values)
}

/// A mechanism whose terms are those of one state everywhere: its constraints are linear, and have the residuals of
/// that state at zero coordinates and zero rates.
struct Held<'a> {
    mechanism: &'a dyn Mechanism,
    dynamics: Dynamics,
    residuals: &'a [f64],
}

impl Mechanism for Held<'_> {
    delegate_without_kernel!(mechanism);

    fn dynamics(&self, _: f64, _: &[f64], _: &[f64], dynamics: DynamicsMut) {
        dynamics.mass_matrix.copy_from_slice(self.dynamics.mass_matrix.entries());
        dynamics.generalized_forces.copy_from_slice(&self.dynamics.generalized_forces);
        dynamics.constraint_jacobian.copy_from_slice(self.dynamics.constraint_jacobian.entries());
        dynamics.constraint_bias.copy_from_slice(&self.dynamics.constraint_bias);
    }

    fn loop_constraints(&self, _: f64, q: &[f64], constraints: LoopConstraintsMut) {
        let rows = self.dynamics.constraint_jacobian.iter().zip(self.residuals);
        for (residual, (row, at_zero)) in constraints.residuals.iter_mut().zip(rows) {
            *residual = at_zero + dot(row, q);
        }
        constraints.constraint_jacobian.copy_from_slice(self.dynamics.constraint_jacobian.entries());
        constraints.constraint_rate.copy_from_slice(self.residuals);
    }

    fn mass_matrix(&self, _: &[f64], mass_matrix: &mut [f64]) {
        mass_matrix.copy_from_slice(self.dynamics.mass_matrix.entries());
    }
}

fn solver<const N: usize, const M: usize>(x: &dyn Mechanism, s: &State<N, M>) -> Option<Values<DoubleDouble>> {
    let dynamics = Dynamics::at(x, s.t, &s.q, &s.qd);
    Ldl::new(&dynamics.mass_matrix)?;
    let held = Held { mechanism: x, dynamics, residuals: &s.residuals };
    let mut solver = Solver::new(&held);
    // At rest nothing is interpolated across singular positions.
    let zero = [0.0; N];
    let (mut qdd, mut multipliers) = ([0.0; N], [0.0; M]);
    solver.robust_accelerations(&held, s.t, (&zero, &zero), (&mut qdd, &mut multipliers)).ok()?;
    solver.factor_mass(&held, &zero);
    let (mut of_coordinates, mut of_rates) = (zero, zero);
    let projection = (Projection::Mass, ProjectionTolerance::default());
    if solver.project(&held, projection, s.t, &mut of_coordinates, &mut of_rates).is_err() {
        // Not a number agrees with no reference.
        (of_coordinates, of_rates) = ([f64::NAN; N], [f64::NAN; N]);
    }
    Some(in_double_double(vec![
        ("accelerations", qdd.to_vec()),
        ("multipliers", multipliers.to_vec()),
        ("correction", of_coordinates.to_vec()),
        ("correction", of_rates.to_vec()),
    ]))
}

/// The outputs at a position that a kernel knows already; a kernel by hand may take closed loops for granted there.
pub(crate) const OUTPUTS_AT: &str = "outputs at a known position";

/// Where a kernel magnifies rounding errors by more, its results are not compared.
pub(crate) const WELL_CONDITIONED_GROWTH: f64 = 20.0;

fn kernel<X: Generated<N, M>, R: Number, const N: usize, const M: usize>(
    mechanism: &dyn Mechanism,
    _: &Tape,
    state: &State<N, M>,
) -> Option<Values<DoubleDouble>> {
    let parameters = mechanism.parameters();
    let kernel = X::Kernel::<R>::with_values(&|i| R::from_f64(parameters[i]));
    let (t, q, qd) = (R::input(state.t), state.q.map(R::input), state.qd.map(R::input));
    let angles = Angles::new(&q, kernel.has_angle());
    let position = kernel.position(t, &q, &angles);
    if !(kernel.growth_factor(&position).value().hi() < WELL_CONDITIONED_GROWTH) {
        return None;
    }
    let (qdd, multipliers) = kernel.accelerations(&position, t, &q, &qd, &angles);
    let mut outputs = vec![R::zero(); X::DESCRIPTION.outputs.len()];
    let mut outputs_at = outputs.clone();
    let (given_qdd, given) = (state.qdd.map(R::input), state.multipliers.map(R::input));
    kernel.outputs(t, &q, &qd, &given_qdd, &given, &mut outputs);
    kernel.outputs_at(&position, t, &q, &qd, &angles, &given_qdd, &given, &mut outputs_at);
    let correction = kernel.correction(&position, &state.residuals.map(R::from_f64));
    Some(in_double_double(vec![
        ("constraints", kernel.residuals(&position).to_vec()),
        ("velocity residual", kernel.velocity_residual(&position, &qd).to_vec()),
        ("accelerations", qdd.to_vec()),
        ("multipliers", multipliers.to_vec()),
        ("correction", correction.to_vec()),
        ("outputs", outputs),
        (OUTPUTS_AT, outputs_at),
        ("event", kernel.event(t, &q, &qd, &qdd, &multipliers).into_iter().collect()),
    ]))
}
