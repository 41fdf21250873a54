//! Steps of RODAS on dual numbers.

use std::convert::Infallible;

use qrm_core::Scalar;

use super::equations::{DualEquations, DualState};
use super::number::{Inner, Number, complete, constants, values};
use super::saddle::less_product;
use super::slope::Slope;
use crate::integrate::StepError;
use crate::integrate::rodas::{ARGUMENTS, BY_TIME, GAMMA, INCREMENTS, NODES};
use crate::solve::{Lu, Matrix, has_momenta, linearization_of_tree};

/// The state at `t` by one step of RODAS, whose matrix has derivatives too.
///
/// # Errors
/// The step cannot be made.
pub(super) fn step<T: Inner>(
    equations: &mut DualEquations<T>,
    from: &DualState<T>,
    t: Number<T>,
) -> Result<DualState<T>, StepError> {
    let (h, one) = (t - from.t, Number::from_f64(1.0));
    let system = System::new(equations, from, h)?;
    let row = |weights: &'static [f64; 5], stage: usize| weights.iter().copied().enumerate().take(stage);
    let mut increments = Vec::with_capacity(NODES.len());
    let mut end = from.place();
    for stage in 0..NODES.len() {
        end = from.place().plus(h, row(&ARGUMENTS[stage], stage), &increments);
        let [qdd, _] = if stage == 0 {
            [from.qdd.clone(), from.multipliers.clone()]
        } else {
            equations.accelerations(from.t + Number::from_f64(NODES[stage]) * h, &end.q, &end.qd)?
        };
        let slope = Slope { q: end.qd.clone(), qd: qdd };
        let slope = slope.plus(one, row(&INCREMENTS[stage], stage), &increments);
        increments.push(system.increment(&slope, Number::from_f64(BY_TIME[stage]) * h));
    }
    // The last increment ends the step.
    let Slope { q, qd } = end.plus(h, [(NODES.len() - 1, 1.0)], &increments);
    equations.projected(t, q, qd)
}

/// The linear equations of all stages of a step of length `h`, with `g = h gamma`:
///
/// ```text
/// | Mbar + g D + g^2 K     C_q' | | w  |         | Mbar r - g K v + d f_t  |
/// | C_q + g D_c + g^2 K_c  0    | | mu | = gamma | C_q r - g K_c v + d c_t |
/// ```
///
/// Increments are divided by `h`: the length of a step may be zero, and its derivatives not.
struct System<T: Inner> {
    h: Number<T>,
    parts: usize,
    n: usize,
    /// The matrix on the left, row by row, and the factors of its values.
    matrix: Vec<Number<T>>,
    factors: Lu,
    /// For each equation its rows of `Mbar` or `C_q`, and of `K` or `K_c`, and its entry of `f_t` or `c_t`.
    mass: Vec<Number<T>>,
    stiffness: Vec<Number<T>>,
    forcing: Vec<Number<T>>,
}

impl<T: Inner> System<T> {
    /// The equations of a step from a state.
    ///
    /// # Errors
    /// The scene does not give the derivatives of its equations of motion, or the equations are singular.
    fn new(equations: &mut DualEquations<T>, from: &DualState<T>, h: Number<T>) -> Result<Self, StepError> {
        let g = Number::from_f64(GAMMA) * h;
        let tape = equations.evaluator.tape();
        let (n, m) = (from.q.len(), from.multipliers.len());
        let zero = |size: usize| vec![Number::zero(); size];
        let mut dynamics = zero(tape.dynamics_length());
        equations.evaluator.dynamics(from.t, &from.q, &from.qd, &mut dynamics);
        let DualState { t, q, qd, qdd, multipliers } = from;
        let [mass, _, jacobian, _] = tape.split_dynamics(&dynamics);
        let [stiffness, damping, forcing] = if has_momenta(Some(tape)) {
            linearization_of_tree(tape, equations.evaluator.parameters(), *t, [q, qd, qdd])
        } else {
            let mut linearization = zero(tape.linearization.as_ref().ok_or(StepError::NoLinearization)?.results.len());
            equations.evaluator.linearization(*t, q, qd, qdd, multipliers, &mut linearization);
            let [stiffness, damping, of_constraints, constraint_damping, forcing, constraint_forcing] =
                tape.split_linearization(&linearization);
            [[stiffness, of_constraints], [damping, constraint_damping], [forcing, constraint_forcing]]
                .map(|parts| parts.concat())
        };
        let mass = [mass, jacobian].concat();
        let size = n + m;
        let mut matrix = vec![Number::zero(); size * size];
        for (i, row) in matrix.chunks_exact_mut(size).enumerate() {
            for j in 0..n {
                let place = i * n + j;
                row[j] = mass[place] + g * (damping[place] + g * stiffness[place]);
            }
            if i < n {
                (0..m).for_each(|k| row[n + k] = jacobian[k * n + i]);
            }
        }
        let reals = values(&matrix);
        let factors = Lu::new(Matrix::from_fn(size, size, |i, j| reals[i * size + j]));
        if !factors.is_regular {
            return Err(StepError::NotFinite);
        }
        Ok(Self { h, parts: equations.parts, n, matrix, factors, mass, stiffness, forcing })
    }

    /// The increment `(u, w)` of coordinates and rates, over `h`, for a slope `(v, r)` and a part of the derivative by
    /// time.
    fn increment(&self, slope: &Slope<T>, by_time: Number<T>) -> Slope<T> {
        let Self { h, n, .. } = self;
        let gamma = Number::from_f64(GAMMA);
        let held: Vec<Number<T>> = slope.q.iter().map(|v| gamma * *h * *v).collect();
        let rows = self.mass.chunks_exact(*n).zip(self.stiffness.chunks_exact(*n)).zip(&self.forcing);
        let right: Vec<Number<T>> = rows
            .map(|((mass, stiffness), forcing)| {
                let inertia = less_product(Number::zero(), mass, &slope.qd);
                gamma * (less_product(by_time * *forcing, stiffness, &held) - inertia)
            })
            .collect();
        let mut w = constants(&self.factors.solve(&values(&right)));
        let open = |w: &[Number<T>]| {
            let rows = right.iter().zip(self.matrix.chunks_exact(w.len()));
            Ok(rows.map(|(right, row)| less_product(*right, row, w)).collect())
        };
        let Ok(()) = complete(&mut w, self.parts, open, |right| Ok::<_, Infallible>(self.factors.solve(&right)));
        w.truncate(*n);
        let u = w.iter().zip(&slope.q).map(|(w, v)| gamma * (*h * *w + *v)).collect();
        Slope { q: u, qd: w }
    }
}
