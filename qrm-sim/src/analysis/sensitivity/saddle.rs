//! The saddle-point equations on dual numbers.

use num_dual::Dual64;
use qrm_core::Dual;

use crate::solve::{SaddlePoint, SolverStats, Undetermined};

/// A number with its derivative by one parameter.
pub(super) type Number = Dual<Dual64>;

/// Solves `M x + J' w = f`, `J x + b = 0` on dual numbers.
///
/// With `x` and `w` known, their derivatives solve the same equations with `df - dM x - dJ' w` and `db + dJ x` on the
/// right.
pub(super) struct DualSaddlePoint {
    /// Statistics of the solves so far.
    pub(super) stats: SolverStats,
    reals: SaddlePoint,
    x: Vec<f64>,
    w: Vec<f64>,
    dx: Vec<f64>,
    dw: Vec<f64>,
}

/// `M` (`n` by `n`), `f` (`n`), `J` (`m` by `n`) and `b` (`m`); matrices row by row.
pub(super) struct Equations<'a> {
    pub(super) mass_matrix: &'a [Number],
    pub(super) forces: &'a [Number],
    pub(super) jacobian: &'a [Number],
    pub(super) bias: &'a [Number],
}

impl DualSaddlePoint {
    /// Room for `n` unknowns and `m` constraints.
    pub(super) fn zero(n: usize, m: usize) -> Self {
        let (stats, reals) = (SolverStats::default(), SaddlePoint::zero(n, m));
        Self { stats, reals, x: vec![0.0; n], w: vec![0.0; m], dx: vec![0.0; n], dw: vec![0.0; m] }
    }

    /// Solves the equations.
    ///
    /// # Errors
    /// `M` is singular on the null space of `J`, or a value is not finite.
    pub(super) fn solve(
        &mut self,
        equations: &Equations,
        x: &mut [Number],
        multipliers: &mut [Number],
    ) -> Result<(), Undetermined> {
        let Self { stats, reals, .. } = self;
        let n = self.x.len();
        let real = &mut reals.dynamics;
        copy_values(equations.mass_matrix, real.mass_matrix.entries_mut());
        copy_values(equations.jacobian, real.constraint_jacobian.entries_mut());
        copy_values(equations.forces, &mut real.generalized_forces);
        copy_values(equations.bias, &mut real.constraint_bias);
        let is_regular = reals.factor();
        if is_regular {
            reals.solve_factored(&mut self.x, &mut self.w);
        } else {
            reals.solve_robustly(&mut self.x, &mut self.w, stats)?;
        }
        let real = &mut reals.dynamics;
        let forces = real.generalized_forces.iter_mut().zip(equations.forces).enumerate();
        for (i, (force, given)) in forces {
            *force = given.0.eps - derivative_dot(&equations.mass_matrix[i * n..], &self.x);
            for (k, w) in self.w.iter().enumerate() {
                *force -= equations.jacobian[k * n + i].0.eps * w;
            }
        }
        for (k, (bias, given)) in real.constraint_bias.iter_mut().zip(equations.bias).enumerate() {
            *bias = given.0.eps + derivative_dot(&equations.jacobian[k * n..], &self.x);
        }
        if is_regular {
            reals.solve_factored(&mut self.dx, &mut self.dw);
        } else {
            reals.solve_robustly(&mut self.dx, &mut self.dw, stats)?;
        }
        join(&self.x, &self.dx, x);
        join(&self.w, &self.dw, multipliers);
        Ok(())
    }
}

/// The derivative of `row . x` with `x` held.
fn derivative_dot(row: &[Number], x: &[f64]) -> f64 {
    row.iter().zip(x).map(|(entry, x)| entry.0.eps * x).sum()
}

fn copy_values(numbers: &[Number], values: &mut [f64]) {
    for (value, number) in values.iter_mut().zip(numbers) {
        *value = number.0.re;
    }
}

fn join(values: &[f64], derivatives: &[f64], numbers: &mut [Number]) {
    for ((number, value), derivative) in numbers.iter_mut().zip(values).zip(derivatives) {
        *number = Dual(Dual64::new(*value, *derivative));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn dual(value: f64, derivative: f64) -> Number {
        Dual(Dual64::new(value, derivative))
    }

    /// Masses `p` and 2 in line, held at a distance, pulled by forces 3 and 1: both accelerate by `4 / (2 + p)`.
    #[test]
    fn derivatives_of_a_rod() {
        let (zero, one) = (dual(0.0, 0.0), dual(1.0, 0.0));
        let equations = Equations {
            mass_matrix: &[dual(1.0, 1.0), zero, zero, dual(2.0, 0.0)],
            forces: &[dual(3.0, 0.0), one],
            jacobian: &[one, dual(-1.0, 0.0)],
            bias: &[zero],
        };
        let (mut x, mut multipliers) = ([zero; 2], [zero]);
        let mut saddle = DualSaddlePoint::zero(2, 1);
        saddle.solve(&equations, &mut x, &mut multipliers).expect("regular");
        for x in x {
            assert!((x.0.re - 4.0 / 3.0).abs() < 1e-15 && (x.0.eps + 4.0 / 9.0).abs() < 1e-15, "{x:?}");
        }
        // lambda = 3 - 4 p / (2 + p)
        let lambda = multipliers[0].0;
        assert!((lambda.re - 5.0 / 3.0).abs() < 1e-15 && (lambda.eps + 8.0 / 9.0).abs() < 1e-15, "{lambda:?}");
    }
}
