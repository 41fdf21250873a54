//! The derivatives of the equations of motion of large trees with respect to the state.

use num_dual::DualSVec;
use qrm_core::{Dual, DualKind, Scalar, Tape, TapeEvaluator};

use crate::differentiated::{Differentiated, PARTS, derivative, differentiated};

/// Whether [`linearization_of_tree`] gives derivatives. Pages have no implicit methods, and are to be small.
pub(crate) fn has_momenta(tape: Option<&Tape>) -> bool {
    cfg!(feature = "extremes") && tape.is_some_and(|tape| tape.momenta.is_some())
}

/// The stiffness `(Mbar qdd - fbar)_q`, the damping `-fbar_qd` and the forcing `fbar_t` of a large tree, matrices row
/// by row.
///
/// `Mbar qdd` are the momenta with the accelerations as rates: a derivative takes as many operations as there are
/// bodies, and no derivatives are generated.
pub(crate) fn linearization_of_tree<D: DualKind>(
    tape: &Tape,
    parameters: &[Dual<D>],
    t: Dual<D>,
    [q, qd, qdd]: [&[Dual<D>]; 3],
) -> [Vec<Dual<D>>; 3] {
    let n = q.len();
    let zero = |size: usize| vec![Dual::<D>::zero(); size];
    let [mut stiffness, mut damping, mut forcing] = [zero(n * n), zero(n * n), zero(n)];
    let mut evaluator = TapeEvaluator::<Vec<Differentiated<D>>>::new(tape);
    evaluator.set_parameters(|i| Some(constant(parameters[i])));
    let qdd: Vec<_> = qdd.iter().map(|x| constant(*x)).collect();
    let (mut momenta, mut forces) = (vec![Differentiated::zero(); n], vec![Differentiated::zero(); n]);
    // Coordinates, rates, time.
    for from in (0..=2 * n).step_by(PARTS) {
        let seeded = |values: &[Dual<D>], first: usize| -> Vec<_> {
            let part = |i: usize| (first + i).checked_sub(from).filter(|part| *part < PARTS);
            values.iter().enumerate().map(|(i, x)| part(i).map_or_else(|| constant(*x), |k| variable(*x, k))).collect()
        };
        let (q, qd, t) = (seeded(q, 0), seeded(qd, n), seeded(&[t], 2 * n)[0]);
        if from < n {
            evaluator.momenta(&q, &qdd, &mut momenta);
        } else {
            // They depend on coordinates alone.
            momenta.fill(Differentiated::zero());
        }
        evaluator.generalized_forces(t, &q, &qd, &mut forces);
        for (k, place) in (from..=2 * n).take(PARTS).enumerate() {
            for i in 0..n {
                let excess = Dual(derivative(&momenta[i], k) - derivative(&forces[i], k));
                match place {
                    j if j < n => stiffness[i * n + j] = excess,
                    j if j < 2 * n => damping[i * n + j - n] = excess,
                    _ => forcing[i] = -excess,
                }
            }
        }
    }
    [stiffness, damping, forcing]
}

fn constant<D: DualKind>(value: Dual<D>) -> Differentiated<D> {
    Dual(DualSVec::from_re(value.0))
}

fn variable<D: DualKind>(value: Dual<D>, part: usize) -> Differentiated<D> {
    differentiated(value.0, std::array::from_fn(|k| D::from(if k == part { 1.0 } else { 0.0 })))
}
