//! A consistent start: what the user gives is kept, the rest is solved for.

use qrm_core::{Mechanism, Start};

use crate::linear::{Ldl, PivotedLdl, Vector, dot, largest};

/// The constraints cannot be met with what is given.
#[derive(Clone, Debug, PartialEq)]
pub struct NotAssembled {
    /// The constraint that cannot be met.
    pub constraint: usize,
    /// How far it stays from closed when all others are: a length or angle for positions, its rate for rates.
    pub residual: f64,
    /// The nearest position that was found.
    pub q: Vec<f64>,
    /// Whether it is the rates that cannot be solved for.
    pub rates: bool,
}

/// Most iterations of the search for a position.
const ITERATIONS: usize = 200;
/// Residual up to which a position counts as assembled.
const CLOSED: f64 = 1e-12;

/// Positions at t = 0 by damped Gauss-Newton iteration from the guesses, rates by one linear solve.
///
/// # Errors
/// Some constraint cannot be met.
pub fn assemble<X: Mechanism<N, M>, const N: usize, const M: usize>(
    mechanism: &X,
    start: &Start<f64, N>,
) -> Result<(Vector<N>, Vector<N>), NotAssembled> {
    let found = search(mechanism, start, start.q, &[1.0; M]);
    if !is_closed(mechanism, &found) {
        return Err(blame(mechanism, start, &found));
    }
    let qd = rates(mechanism, start, &found)?;
    Ok((found, qd))
}

/// Whether every residual is at the size of rounding errors, of its own or of the terms it is the difference of.
fn is_closed<X: Mechanism<N, M>, const N: usize, const M: usize>(mechanism: &X, q: &Vector<N>) -> bool {
    let closure = mechanism.closure(0.0, q);
    let terms = |row: &Vector<N>| row.iter().zip(q).map(|(derivative, q)| (derivative * q).abs()).sum::<f64>();
    let rows = closure.constraints.iter().zip(&closure.constraint_jacobian);
    rows.into_iter().all(|(residual, row)| residual.abs() <= CLOSED.max(64.0 * f64::EPSILON * terms(row)))
}

/// The last constraint that alone stays open when all others are closed, and how far; failing that, the one that is
/// farthest from closed.
fn blame<X: Mechanism<N, M>, const N: usize, const M: usize>(
    mechanism: &X,
    start: &Start<f64, N>,
    found: &Vector<N>,
) -> NotAssembled {
    let alone = (0..M).rev().find_map(|constraint| {
        let mut weights = [1.0; M];
        weights[constraint] = 1e-6;
        let q = search(mechanism, start, *found, &weights);
        let mut residuals = mechanism.closure(0.0, &q).constraints;
        let residual = std::mem::replace(&mut residuals[constraint], 0.0).abs();
        (largest(&residuals).1 <= 1e-9).then_some((constraint, residual, q))
    });
    let (constraint, residual, q) = alone.unwrap_or_else(|| {
        let (constraint, residual) = largest(&mechanism.closure(0.0, found).constraints);
        (constraint, residual, *found)
    });
    NotAssembled { constraint, residual, q: q.to_vec(), rates: false }
}

/// Minimises the weighted residuals over the coordinates that are not given (Levenberg-Marquardt).
fn search<X: Mechanism<N, M>, const N: usize, const M: usize>(
    mechanism: &X,
    start: &Start<f64, N>,
    from: Vector<N>,
    weights: &Vector<M>,
) -> Vector<N> {
    let cost = |q: &Vector<N>| {
        let residual = mechanism.closure(0.0, q).constraints;
        residual.iter().zip(weights).map(|(r, w)| (r * w).powi(2)).sum::<f64>()
    };
    let mut q = from;
    let mut damping = 1e-3;
    let mut now = cost(&q);
    for _ in 0..ITERATIONS {
        let closure = mechanism.closure(0.0, &q);
        let mut normal = [[0.0; N]; N];
        let mut slope = [0.0; N];
        for ((row, residual), weight) in closure.constraint_jacobian.iter().zip(closure.constraints).zip(weights) {
            let row: Vector<N> = std::array::from_fn(|i| if start.given[i] { 0.0 } else { row[i] * weight });
            for i in 0..N {
                slope[i] -= row[i] * residual * weight;
                for j in 0..N {
                    normal[i][j] += row[i] * row[j];
                }
            }
        }
        let size = (0..N).fold(0.0, |most: f64, i| most.max(normal[i][i]));
        for (i, row) in normal.iter_mut().enumerate() {
            row[i] += if start.given[i] { 1.0 } else { damping * size + f64::MIN_POSITIVE };
        }
        let Some(factors) = Ldl::new(&normal) else {
            damping *= 10.0;
            continue;
        };
        let step = factors.solve(&slope);
        let next: Vector<N> = std::array::from_fn(|i| q[i] + step[i]);
        let then = cost(&next);
        if then < now {
            (q, now) = (next, then);
            damping = (damping * 0.1).max(1e-15);
        } else if damping > 1e6 || now == 0.0 {
            break;
        } else {
            damping *= 10.0;
        }
    }
    q
}

/// The rates that are not given, from `C_q qd + C_t = 0`.
fn rates<X: Mechanism<N, M>, const N: usize, const M: usize>(
    mechanism: &X,
    start: &Start<f64, N>,
    q: &Vector<N>,
) -> Result<Vector<N>, NotAssembled> {
    let closure = mechanism.closure(0.0, q);
    let jacobian = &closure.constraint_jacobian;
    let mut qd: Vector<N> = std::array::from_fn(|i| if start.given_rates[i] { start.qd[i] } else { 0.0 });
    let free = Free::new(jacobian, &start.given_rates);
    // The second pass removes the rounding errors of the first.
    for _ in 0..2 {
        let open = closure.drift(&qd);
        free.follow(&mut qd, &open);
    }
    let (constraint, residual) = largest(&closure.drift(&qd));
    let scale = qd.iter().fold(1.0, |most: f64, v| most.max(v.abs()));
    if !(residual <= 1e-9 * scale) {
        return Err(NotAssembled { constraint, residual, q: q.to_vec(), rates: true });
    }
    Ok(qd)
}

/// How what is not given follows by the constraints.
pub(crate) struct Free<const N: usize, const M: usize> {
    /// The Jacobian, without the columns of what is given.
    rows: [Vector<N>; M],
    factors: PivotedLdl<M>,
}

impl<const N: usize, const M: usize> Free<N, M> {
    pub(crate) fn new(jacobian: &[Vector<N>; M], given: &[bool; N]) -> Self {
        let rows: [Vector<N>; M] =
            std::array::from_fn(|r| std::array::from_fn(|i| if given[i] { 0.0 } else { jacobian[r][i] }));
        let schur: [Vector<M>; M] = std::array::from_fn(|i| std::array::from_fn(|j| dot(&rows[i], &rows[j])));
        Self { rows, factors: PivotedLdl::new(&schur) }
    }

    /// Moves `x` by the smallest `dx` with `C_q dx = -open`.
    pub(crate) fn follow(&self, x: &mut Vector<N>, open: &Vector<M>) {
        for (row, weight) in self.rows.iter().zip(self.factors.solve(open)) {
            for i in 0..N {
                x[i] -= weight * row[i];
            }
        }
    }
}
