//! How accelerations react to small changes of the state.

use qrm_core::{Dynamics, Linearization, Mechanism};

use crate::linear::{Vector, dot};
use crate::motion::Moment;
use crate::solve::{Care, accelerations};

/// The equations of motion about one moment: `qdd` and `lambda` change with coordinates and rates as the solution of the same
/// system for another right-hand side.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Response<const N: usize, const M: usize> {
    pub(crate) dynamics: Dynamics<f64, N, M>,
    linearization: Linearization<f64, N, M>,
}

impl<const N: usize, const M: usize> Response<N, M> {
    /// By the generated derivatives; `None` if the scene does not ask for them.
    pub(crate) fn generated<X: Mechanism<N, M>>(mechanism: &X, at: &Moment<N, M>) -> Option<Self> {
        let linearization = mechanism.linearization(at.t, &at.q, &at.qd, &at.qdd, &at.multipliers)?;
        Some(Self { dynamics: mechanism.dynamics(at.t, &at.q, &at.qd), linearization })
    }

    /// By the generated derivatives, or by differences if there are none.
    #[cfg(feature = "stability")]
    pub(crate) fn new<X: Mechanism<N, M>>(mechanism: &X, at: &Moment<N, M>) -> Self {
        Self::generated(mechanism, at).unwrap_or_else(|| Self {
            dynamics: mechanism.dynamics(at.t, &at.q, &at.qd),
            linearization: differences(mechanism, at),
        })
    }

    /// The change of the accelerations for a change `u` of the coordinates and `w` of the rates; `None` if they are not determined.
    pub(crate) fn accelerations(&self, u: &Vector<N>, w: &Vector<N>) -> Option<Vector<N>> {
        let linearization = &self.linearization;
        let changed = Dynamics {
            generalized_forces: std::array::from_fn(|i| {
                -dot(&linearization.stiffness[i], u) - dot(&linearization.damping[i], w)
            }),
            constraint_bias: std::array::from_fn(|k| {
                dot(&linearization.constraint_stiffness[k], u) + dot(&linearization.constraint_damping[k], w)
            }),
            ..self.dynamics
        };
        Some(accelerations(&changed, &mut Care::default()).ok()?.qdd)
    }
}

/// Relative step of central differences, about the cube root of the rounding error.
#[cfg(feature = "stability")]
const STEP: f64 = 6e-6;

/// The derivatives by central differences of the equations of motion, accelerations and multipliers held.
#[cfg(feature = "stability")]
fn differences<X: Mechanism<N, M>, const N: usize, const M: usize>(
    mechanism: &X,
    at: &Moment<N, M>,
) -> Linearization<f64, N, M> {
    let residuals = |q: &Vector<N>, qd: &Vector<N>| -> (Vector<N>, Vector<M>) {
        let d = mechanism.dynamics(at.t, q, qd);
        let force = |i: usize| (0..M).map(|k| d.constraint_jacobian[k][i] * at.multipliers[k]).sum::<f64>();
        let of_motion = |i: usize| dot(&d.mass_matrix[i], &at.qdd) + force(i) - d.generalized_forces[i];
        let of_loops = |k: usize| dot(&d.constraint_jacobian[k], &at.qdd) + d.constraint_bias[k];
        (std::array::from_fn(of_motion), std::array::from_fn(of_loops))
    };
    let mut found = Linearization {
        stiffness: [[0.0; N]; N],
        damping: [[0.0; N]; N],
        constraint_stiffness: [[0.0; N]; M],
        constraint_damping: [[0.0; N]; M],
        forcing: [0.0; N],
        constraint_forcing: [0.0; M],
    };
    for j in 0..N {
        let moved = |x: &Vector<N>, by: f64| -> Vector<N> {
            let mut moved = *x;
            moved[j] += by;
            moved
        };
        let (of_q, of_qd) = (STEP * (1.0 + at.q[j].abs()), STEP * (1.0 + at.qd[j].abs()));
        let (low, high) = (residuals(&moved(&at.q, -of_q), &at.qd), residuals(&moved(&at.q, of_q), &at.qd));
        let (slow, fast) = (residuals(&at.q, &moved(&at.qd, -of_qd)), residuals(&at.q, &moved(&at.qd, of_qd)));
        for i in 0..N {
            found.stiffness[i][j] = (high.0[i] - low.0[i]) / (2.0 * of_q);
            found.damping[i][j] = (fast.0[i] - slow.0[i]) / (2.0 * of_qd);
        }
        for k in 0..M {
            found.constraint_stiffness[k][j] = (high.1[k] - low.1[k]) / (2.0 * of_q);
            found.constraint_damping[k][j] = (fast.1[k] - slow.1[k]) / (2.0 * of_qd);
        }
    }
    found
}
