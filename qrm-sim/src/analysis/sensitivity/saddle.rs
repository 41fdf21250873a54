//! The saddle-point equations on dual numbers.

use qrm_core::Scalar;

use super::number::{Inner, Number, complete, constants};
use crate::solve::{PreciseSaddlePoint, SINGULAR, SaddlePoint, SingularityDistance, SolverStats, Undetermined};

/// The smallest pivot of the Schur complement for which solutions have twelve digits. Masses that differ by many orders
/// of magnitude make it smaller, although the constraints are independent.
const DIGITS: f64 = 1e-4;

/// Solves `M x + J' w = f`, `J x + b = 0` on dual numbers.
pub(super) struct DualSaddlePoint {
    /// Statistics of the solves so far.
    pub(super) stats: SolverStats,
    reals: SaddlePoint,
    /// The distance of positions from singular ones, since the first.
    distance: Option<SingularityDistance>,
    /// The number of parameters.
    parts: usize,
}

/// `M` (`n` by `n`), `f` (`n`), `J` (`m` by `n`) and `b` (`m`); matrices row by row.
pub(super) struct Equations<'a, T: Inner> {
    pub(super) mass_matrix: &'a [Number<T>],
    pub(super) forces: &'a [Number<T>],
    pub(super) jacobian: &'a [Number<T>],
    pub(super) bias: &'a [Number<T>],
}

impl DualSaddlePoint {
    /// Room for `n` unknowns and `m` constraints, with derivatives by so many parameters.
    pub(super) fn zero(n: usize, m: usize, parts: usize) -> Self {
        Self { stats: SolverStats::default(), reals: SaddlePoint::zero(n, m), distance: None, parts }
    }

    /// The solution `x`, then `w`.
    ///
    /// # Errors
    /// `M` is singular on the null space of `J`, or a value is not finite.
    pub(super) fn solve<T: Inner>(&mut self, equations: &Equations<T>) -> Result<Vec<Number<T>>, Undetermined> {
        let n = equations.forces.len();
        copy_values(equations.mass_matrix, self.reals.dynamics.mass_matrix.entries_mut());
        copy_values(equations.jacobian, self.reals.dynamics.constraint_jacobian.entries_mut());
        let is_regular = self.reals.factor_above(DIGITS);
        let precise = if is_regular { None } else { self.precise() };
        let Self { stats, reals, parts, .. } = self;
        let mut solve = |mut solution: Vec<f64>| {
            if let Some(precise) = &precise {
                return Ok(precise.solve(&solution));
            }
            let (x, w) = solution.split_at_mut(n);
            reals.dynamics.generalized_forces.copy_from_slice(x);
            reals.dynamics.constraint_bias.iter_mut().zip(&*w).for_each(|(bias, right)| *bias = -right);
            if is_regular {
                reals.solve_factored(x, w);
            } else {
                reals.solve_robustly(x, w, stats)?;
            }
            Ok(solution)
        };
        let right = equations.forces.iter().copied().chain(equations.bias.iter().map(|bias| -*bias));
        let mut x = constants(&solve(right.map(Scalar::to_f64).collect())?);
        complete(&mut x, *parts, |x| Ok(equations.open(x)), solve)?;
        Ok(x)
    }

    /// The factors in double-double precision, unless the position is near a singular one.
    fn precise(&mut self) -> Option<PreciseSaddlePoint> {
        let dynamics = &self.reals.dynamics;
        let (n, m) = (dynamics.generalized_forces.len(), dynamics.constraint_bias.len());
        let distance = self.distance.get_or_insert_with(|| SingularityDistance::new(m, n, m));
        let value = distance.measure(&dynamics.constraint_jacobian)?;
        if distance.fraction(value, SINGULAR).is_some() { None } else { PreciseSaddlePoint::factored(dynamics) }
    }
}

impl<T: Inner> Equations<'_, T> {
    /// The residuals of the equations at `x` and `w`: `f - M x - J' w`, then `-b - J x`.
    fn open(&self, x: &[Number<T>]) -> Vec<Number<T>> {
        let n = self.forces.len();
        let (x, w) = x.split_at(n);
        let mut open = self.forces.to_vec();
        open.extend(self.bias.iter().map(|bias| -*bias));
        let (of_forces, of_bias) = open.split_at_mut(n);
        for (open, row) in of_forces.iter_mut().zip(self.mass_matrix.chunks_exact(n)) {
            *open = less_product(*open, row, x);
        }
        for ((row, w), open) in self.jacobian.chunks_exact(n).zip(w).zip(of_bias) {
            *open = less_product(*open, row, x);
            of_forces.iter_mut().zip(row).for_each(|(open, entry)| *open = *open - *entry * *w);
        }
        open
    }
}

/// `sum - row . x`
pub(super) fn less_product<T: Inner>(sum: Number<T>, row: &[Number<T>], x: &[Number<T>]) -> Number<T> {
    row.iter().zip(x).fold(sum, |sum, (entry, x)| sum - *entry * *x)
}

fn copy_values<T: Inner>(numbers: &[Number<T>], values: &mut [f64]) {
    for (value, number) in values.iter_mut().zip(numbers) {
        *value = number.to_f64();
    }
}

#[cfg(test)]
mod tests {
    use num_dual::Dual64;

    use super::super::number::{Number, differentiated, with_part};
    use super::*;

    /// A number with derivatives by `p` and `f`, and along `p` where there is a direction.
    fn dual<T: Inner>(value: f64, by_p: f64, by_f: f64) -> Number<T> {
        let by = |i: usize| T::from([by_p, by_f].get(i).copied().unwrap_or(0.0));
        differentiated(T::new(value, by_p), std::array::from_fn(by))
    }

    /// Masses `p` and 2 in line, held at a distance, pulled by forces `f = 3` and 1: both accelerate by
    /// `(f + 1) / (2 + p)`.
    fn rod<T: Inner>() -> Vec<Number<T>> {
        let (zero, one) = (dual(0.0, 0.0, 0.0), dual(1.0, 0.0, 0.0));
        let equations = Equations {
            mass_matrix: &[dual(1.0, 1.0, 0.0), zero, zero, dual(2.0, 0.0, 0.0)],
            forces: &[dual(3.0, 0.0, 1.0), one],
            jacobian: &[one, dual(-1.0, 0.0, 0.0)],
            bias: &[zero],
        };
        DualSaddlePoint::zero(2, 1, 2).solve(&equations).expect("regular")
    }

    #[test]
    fn derivatives_of_a_rod() {
        let x = rod::<f64>();
        let near = |number: &Number<f64>, place: usize, expected: [f64; 2]| {
            let found = with_part(number, place);
            assert!((found.re - expected[0]).abs() < 1e-15 && (found.eps1 - expected[1]).abs() < 1e-15, "{found:?}");
        };
        for x in &x[..2] {
            near(x, 0, [4.0 / 3.0, -4.0 / 9.0]);
            near(x, 1, [4.0 / 3.0, 1.0 / 3.0]);
        }
        // lambda = f - (f + 1) p / (2 + p)
        near(&x[2], 0, [5.0 / 3.0, -8.0 / 9.0]);
        near(&x[2], 1, [5.0 / 3.0, 2.0 / 3.0]);
    }

    #[test]
    fn second_derivatives_of_a_rod() {
        let found = [0, 1].map(|part| with_part(&rod::<Dual64>()[0], part));
        assert!((found[0].eps2 + 4.0 / 9.0).abs() < 1e-15, "{found:?}");
        assert!((found[0].eps1eps2 - 8.0 / 27.0).abs() < 1e-15, "{found:?}");
        assert!((found[1].eps1eps2 + 1.0 / 9.0).abs() < 1e-15, "{found:?}");
    }
}
