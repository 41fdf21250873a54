//! Steps of the Gauss method on dual numbers.

use std::sync::LazyLock;

use qrm_core::{GAUSS_NODES, Scalar};

use super::equations::{DualEquations, DualState};
use super::number::{Inner, Number, Place};
use super::slope::Slope;
use crate::integrate::StepError;
use crate::quadrature::gauss_legendre;

/// Most iterations of a step; where more are needed, shorter steps take less work.
const MOST_ITERATIONS: usize = 100;
/// Most times that a step is halved: it was short enough for the same iteration without derivatives.
const MOST_HALVINGS: u32 = 10;
/// Slopes that change by this part of the largest have converged.
const CONVERGED: f64 = 1e-15;
/// Changes below this part that fall no more are rounding errors.
const SETTLED: f64 = 1e-11;

/// The state at `t` by a step of the Gauss method, or by shorter ones where its iteration does not converge.
///
/// # Errors
/// A step cannot be made, or steps became too short.
pub(super) fn step<T: Inner>(
    equations: &mut DualEquations<T>,
    from: &DualState<T>,
    t: Number<T>,
) -> Result<DualState<T>, StepError> {
    halved(equations, from, t, MOST_HALVINGS)
}

/// The state at `t` by one step, or by two that are halved as often as is left.
fn halved<T: Inner>(
    equations: &mut DualEquations<T>,
    from: &DualState<T>,
    t: Number<T>,
    halvings: u32,
) -> Result<DualState<T>, StepError> {
    if let Some(made) = iterated(equations, from, t)? {
        return Ok(made);
    }
    let half = Number::from_f64(0.5) * (t - from.t);
    let left = halvings.checked_sub(1).ok_or(StepError::StepTooShort { h: half.to_f64() })?;
    let middle = halved(equations, from, from.t + half, left)?;
    halved(equations, &middle, t, left)
}

/// The state at `t` by one step: collocation at the zeros of a Legendre polynomial, solved by fixed-point iteration,
/// derivatives included; `None` if it does not converge.
fn iterated<T: Inner>(
    equations: &mut DualEquations<T>,
    from: &DualState<T>,
    t: Number<T>,
) -> Result<Option<DualState<T>>, StepError> {
    let h = t - from.t;
    let Rule { nodes, rows } = &*RULE;
    let mut slopes = vec![from.slope(); GAUSS_NODES];
    let mut last = f64::INFINITY;
    for _ in 0..MOST_ITERATIONS {
        let mut change: f64 = 0.0;
        for (stage, (node, _)) in nodes.iter().enumerate() {
            let at = from.place().plus(h, rows[stage].iter().copied().enumerate(), &slopes);
            let [qdd, _] = equations.accelerations(from.t + Number::from_f64(*node) * h, &at.q, &at.qd)?;
            let next = Slope { q: at.qd, qd: qdd };
            for (new, old) in [(&next.q, &slopes[stage].q), (&next.qd, &slopes[stage].qd)] {
                change = change.max(relative_change(equations.parts, new, old));
            }
            slopes[stage] = next;
        }
        if change <= CONVERGED || change >= last && change <= SETTLED {
            let weights = nodes.iter().map(|(_, weight)| *weight);
            let Slope { q, qd } = from.place().plus(h, weights.enumerate(), &slopes);
            return equations.projected(t, q, qd).map(Some);
        }
        last = change;
    }
    Ok(None)
}

/// The coefficients of the method.
struct Rule {
    /// The nodes in a step of length one, with their weights.
    nodes: [(f64, f64); GAUSS_NODES],
    /// For each node the weights of the integrals up to it.
    rows: [[f64; GAUSS_NODES]; GAUSS_NODES],
}

static RULE: LazyLock<Rule> = LazyLock::new(|| {
    let nodes = gauss_legendre();
    Rule { nodes, rows: nodes.map(|(node, _)| integrals_to(node, &nodes)) }
});

/// The integrals from 0 to `c` of the polynomials that are one at a node and zero at the others.
fn integrals_to(c: f64, nodes: &[(f64, f64); GAUSS_NODES]) -> [f64; GAUSS_NODES] {
    std::array::from_fn(|j| {
        let (own, _) = nodes[j];
        let others = || nodes.iter().enumerate().filter(|(k, _)| *k != j).map(|(_, (node, _))| *node);
        let value = |x: f64| others().map(|other| (x - other) / (own - other)).product::<f64>();
        nodes.iter().map(|(x, weight)| c * weight * value(c * x)).sum()
    })
}

/// The largest change of values or of one of their derivatives, relative to the largest of these.
fn relative_change<T: Inner>(parts: usize, new: &[Number<T>], old: &[Number<T>]) -> f64 {
    let of_place = |get: &dyn Fn(&Number<T>) -> f64| {
        let size = new.iter().map(|x| get(x).abs()).fold(f64::MIN_POSITIVE, f64::max);
        new.iter().zip(old).map(|(a, b)| (get(a) - get(b)).abs()).fold(0.0, f64::max) / size
    };
    let derivatives = Place::all::<T>(parts).map(|place| of_place(&|x| place.get(x)));
    derivatives.fold(of_place(&|x| x.to_f64()), f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_are_integrated_exactly_to_each_node() {
        let nodes = gauss_legendre();
        for (c, _) in nodes {
            let integrals = integrals_to(c, &nodes);
            for power in 0..8 {
                let sum: f64 = nodes.iter().zip(integrals).map(|((x, _), weight)| weight * x.powi(power)).sum();
                let exact = c.powi(power + 1) / f64::from(power + 1);
                assert!((sum - exact).abs() < 1e-15, "{power}: {sum} instead of {exact}");
            }
        }
    }
}
