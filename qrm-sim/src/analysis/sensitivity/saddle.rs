//! The saddle-point equations on dual numbers.

use crate::solve::{SaddlePoint, SolverStats, Undetermined};

use super::number::{Number, PARTS, derivatives, number};

/// Solves `M x + J' w = f`, `J x + b = 0` on dual numbers.
///
/// With `x` and `w` known, their derivatives solve the same equations with `df - dM x - dJ' w` and `db + dJ x` on the
/// right.
pub(super) struct DualSaddlePoint {
    /// Statistics of the solves so far.
    pub(super) stats: SolverStats,
    reals: SaddlePoint,
    /// The number of parameters.
    parts: usize,
    x: Vec<f64>,
    w: Vec<f64>,
    /// The right sides for the derivatives, and then the derivatives.
    dx: Vec<[f64; PARTS]>,
    dw: Vec<[f64; PARTS]>,
    part: (Vec<f64>, Vec<f64>),
}

/// `M` (`n` by `n`), `f` (`n`), `J` (`m` by `n`) and `b` (`m`); matrices row by row.
pub(super) struct Equations<'a> {
    pub(super) mass_matrix: &'a [Number],
    pub(super) forces: &'a [Number],
    pub(super) jacobian: &'a [Number],
    pub(super) bias: &'a [Number],
}

impl DualSaddlePoint {
    /// Room for `n` unknowns and `m` constraints, with derivatives by so many parameters.
    pub(super) fn zero(n: usize, m: usize, parts: usize) -> Self {
        Self {
            stats: SolverStats::default(),
            reals: SaddlePoint::zero(n, m),
            parts,
            x: vec![0.0; n],
            w: vec![0.0; m],
            dx: vec![[0.0; PARTS]; n],
            dw: vec![[0.0; PARTS]; m],
            part: (vec![0.0; n], vec![0.0; m]),
        }
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
        for (i, (force, given)) in self.dx.iter_mut().zip(equations.forces).enumerate() {
            *force = derivatives(given);
            subtract_products(force, &equations.mass_matrix[i * n..], 1, &self.x);
            subtract_products(force, equations.jacobian.get(i..).unwrap_or_default(), n, &self.w);
        }
        for (k, (bias, given)) in self.dw.iter_mut().zip(equations.bias).enumerate() {
            // -(db + dJ x)
            *bias = derivatives(given).map(|derivative| -derivative);
            subtract_products(bias, &equations.jacobian[k * n..], 1, &self.x);
        }
        for unused in self.parts..PARTS {
            self.dx.iter_mut().chain(&mut self.dw).for_each(|all| all[unused] = 0.0);
        }
        for part in 0..self.parts {
            let real = &mut reals.dynamics;
            real.generalized_forces.iter_mut().zip(&self.dx).for_each(|(force, all)| *force = all[part]);
            real.constraint_bias.iter_mut().zip(&self.dw).for_each(|(bias, all)| *bias = -all[part]);
            let (dx, dw) = &mut self.part;
            if is_regular {
                reals.solve_factored(dx, dw);
            } else {
                reals.solve_robustly(dx, dw, stats)?;
            }
            self.dx.iter_mut().zip(dx).for_each(|(all, own)| all[part] = *own);
            self.dw.iter_mut().zip(dw).for_each(|(all, own)| all[part] = *own);
        }
        join(&self.x, &self.dx, x);
        join(&self.w, &self.dw, multipliers);
        Ok(())
    }
}

/// `sum -= d row . x`, with every `step`-th entry of the row.
fn subtract_products(sum: &mut [f64; PARTS], row: &[Number], step: usize, x: &[f64]) {
    for (entry, x) in row.iter().step_by(step).zip(x) {
        let derivatives = derivatives(entry);
        for part in 0..PARTS {
            sum[part] -= derivatives[part] * x;
        }
    }
}

fn copy_values(numbers: &[Number], values: &mut [f64]) {
    for (value, number) in values.iter_mut().zip(numbers) {
        *value = number.0.re;
    }
}

fn join(values: &[f64], derivatives: &[[f64; PARTS]], numbers: &mut [Number]) {
    for ((joined, value), derivatives) in numbers.iter_mut().zip(values).zip(derivatives) {
        *joined = number(*value, *derivatives);
    }
}

#[cfg(test)]
mod tests {
    use super::super::number::of_part;
    use super::*;

    fn dual(value: f64, by_p: f64, by_f: f64) -> Number {
        number(value, std::array::from_fn(|i| [by_p, by_f].get(i).copied().unwrap_or(0.0)))
    }

    /// Masses `p` and 2 in line, held at a distance, pulled by forces `f = 3` and 1: both accelerate by
    /// `(f + 1) / (2 + p)`.
    #[test]
    fn derivatives_of_a_rod() {
        let (zero, one) = (dual(0.0, 0.0, 0.0), dual(1.0, 0.0, 0.0));
        let equations = Equations {
            mass_matrix: &[dual(1.0, 1.0, 0.0), zero, zero, dual(2.0, 0.0, 0.0)],
            forces: &[dual(3.0, 0.0, 1.0), one],
            jacobian: &[one, dual(-1.0, 0.0, 0.0)],
            bias: &[zero],
        };
        let (mut x, mut multipliers) = ([zero; 2], [zero]);
        let mut saddle = DualSaddlePoint::zero(2, 1, 2);
        saddle.solve(&equations, &mut x, &mut multipliers).expect("regular");
        let near = |number: &Number, place: usize, expected: [f64; 2]| {
            let found = of_part(number, place);
            assert!((found.re - expected[0]).abs() < 1e-15 && (found.eps - expected[1]).abs() < 1e-15, "{found:?}");
        };
        for x in &x {
            near(x, 0, [4.0 / 3.0, -4.0 / 9.0]);
            near(x, 1, [4.0 / 3.0, 1.0 / 3.0]);
        }
        // lambda = f - (f + 1) p / (2 + p)
        near(&multipliers[0], 0, [5.0 / 3.0, -8.0 / 9.0]);
        near(&multipliers[0], 1, [5.0 / 3.0, 2.0 / 3.0]);
    }
}
