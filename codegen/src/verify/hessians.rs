//! The second derivatives of the constraints, which occur in the derivation.

use super::errors::CONSTANTS;
use super::sample::Sample;
use super::wide::Wide;
use crate::term::{Equations, Symbol, Term};
use qrm_scene::scene::Scene;

/// Compares `C_qq`, contracted with the rates on both sides. The derivation shows it, but no function computes it.
pub(super) fn second_derivatives(
    scene: &Scene,
    equations: &Equations,
    sample: &Sample,
    has_rounded_constants: bool,
) -> Result<(), String> {
    let nearby = sample.nearby();
    let expected = sample.on::<Wide>().quadratic_velocity_term(scene);
    for (k, (hessian, constraint)) in equations.constraint_hessians.iter().zip(&scene.constraints).enumerate() {
        let expected = expected[k].0.hi();
        let (contracted, terms) = contraction(hessian, sample);
        let difference = (contracted - expected).abs();
        let spread = (contraction(hessian, &nearby).0 - contracted).abs();
        let allowed = (1e-7 * expected.abs()).max(1e-11 * terms).max(sample.error_of_zeros(expected.abs()));
        let rounding = || {
            let samples = [sample, &nearby].into_iter();
            samples.map(|s| {
                (s.quadratic_velocity_term(scene)[k] - s.on::<Wide>().quadratic_velocity_term(scene)[k].0.hi()).abs()
            })
        };
        let is_hidden = || has_rounded_constants && difference <= CONSTANTS * rounding().sum::<f64>();
        if !(difference <= allowed) && !(spread > 1e-4 * difference) && !is_hidden() {
            return Err(format!(
                "the C_qq of the derivation is wrong: that of constraint `{}`, contracted with the rates, is \
                 {contracted:e} instead of {expected:e}",
                constraint.name
            ));
        }
    }
    Ok(())
}

/// The contraction, and the sum of the absolute values of its terms.
fn contraction(hessian: &[Vec<Term>], sample: &Sample) -> (f64, f64) {
    let value = |symbol: Symbol| match symbol {
        Symbol::Parameter(i) => sample.parameters[i],
        Symbol::Pi => std::f64::consts::PI,
        Symbol::Coordinate(i) => sample.q[i],
        Symbol::Time => sample.t,
        _ => f64::NAN,
    };
    let (mut sum, mut sizes) = (0.0, 0.0);
    for (row, v) in hessian.iter().zip(&sample.qd) {
        for (entry, w) in row.iter().zip(&sample.qd).filter(|(entry, _)| !entry.is_zero()) {
            let term = entry.evaluate(&value) * v * w;
            sum += term;
            sizes += term.abs();
        }
    }
    (sum, sizes)
}
