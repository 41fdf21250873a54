//! Positions and loops as one writes them down, differentiated while they are computed.

use nalgebra::Const;
use num_dual::{Derivative, Dual2_64, DualNum, DualSVec64};
use qrm_core::{Dynamics, LoopConstraints};
use qrm_model::quick_return::Parameters;

use super::PlainFunctions;

/// The equations by dual numbers at run time.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ByDualNumbers(Parameters);

impl ByDualNumbers {
    /// Rows: crank angle, block x y, rocker x y angle, rod x y angle, ram x; then both loops.
    #[inline(always)]
    fn rows<D: DualNum<Primitive = f64> + Copy>(&self, [phi2, phi4, phi5]: [D; 3]) -> ([D; 10], [D; 2]) {
        let p = &self.0;
        let [(s2, c2), (s4, c4), (s5, c5)] = [phi2.sin_cos(), phi4.sin_cos(), phi5.sin_cos()];
        let (ax, ay) = (c2 * p.O2A, s2 * p.O2A + p.O4O2);
        let (bx, by) = (c4 * p.O4B, s4 * p.O4B);
        let (rod_x, rod_y) = (bx + c5 * p.BG5, by + s5 * p.BG5);
        let positions = [phi2, ax, ay, c4 * p.O4G4, s4 * p.O4G4, phi4, rod_x, rod_y, phi5, bx + c5 * p.BC];
        (positions, [ax - (ax * ax + ay * ay).sqrt() * c4, by + s5 * p.BC - p.yC])
    }

    /// Rows and loops with their derivatives by each coordinate.
    #[inline(always)]
    fn gradients(&self, q: &[f64; 3]) -> ([DualSVec64<3>; 10], [DualSVec64<3>; 2]) {
        let along = |i: usize| DualSVec64::new(q[i], Derivative::derivative_generic(Const::<3>, Const::<1>, i));
        self.rows([along(0), along(1), along(2)])
    }
}

#[inline(always)]
fn gradient(value: &DualSVec64<3>) -> [f64; 3] {
    value.eps.unwrap_generic(Const::<3>, Const::<1>).into()
}

impl PlainFunctions for ByDualNumbers {
    fn new(parameters: Parameters) -> Self {
        Self(parameters)
    }

    #[inline(always)]
    fn dynamics(&self, q: &[f64; 3], qd: &[f64; 3]) -> Dynamics<f64, 3, 2> {
        let p = &self.0;
        let (positions, loops) = self.gradients(q);
        let moving = |i: usize| Dual2_64::new(q[i], qd[i], 0.0);
        let (along, loops_along) = self.rows([moving(0), moving(1), moving(2)]);
        let inertias = [p.J2, p.m3, p.m3, p.m4, p.m4, p.J4, p.m5, p.m5, p.J5, p.m6];
        let (mut mass_matrix, mut generalized_forces) = ([[0.0; 3]; 3], [0.0; 3]);
        for row in 0..10 {
            let t = gradient(&positions[row]);
            let force = if row == 9 { p.F6 } else { 0.0 } - inertias[row] * along[row].v2;
            for i in 0..3 {
                generalized_forces[i] += t[i] * force;
                for j in 0..3 {
                    mass_matrix[i][j] += inertias[row] * t[i] * t[j];
                }
            }
        }
        let [slot, guide] = loops;
        Dynamics {
            mass_matrix,
            generalized_forces,
            constraint_jacobian: [gradient(&slot), gradient(&guide)],
            constraint_bias: loops_along.map(|value| value.v2),
        }
    }

    #[inline(always)]
    fn loop_constraints(&self, q: &[f64; 3]) -> LoopConstraints<f64, 3, 2> {
        let (_, [slot, guide]) = self.gradients(q);
        LoopConstraints {
            residuals: [slot.re, guide.re],
            constraint_jacobian: [gradient(&slot), gradient(&guide)],
            constraint_rate: [0.0; 2],
        }
    }
}
