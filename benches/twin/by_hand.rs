//! The algebra done on paper, as a good engineer would write it.
//!
//! With `r` the distance O4-A, the slot closes as `C1 = O2A cos(phi2) - r cos(phi4)`, where
//! `r^2 = O2A^2 + O4O2^2 + 2 O2A O4O2 sin(phi2)` and so `r' = O2A O4O2 cos(phi2) / r`. Gravity, torque on the crank and
//! inertia of the block are left out, as they are in the scene.

use qrm_core::{Dynamics, LoopConstraints, sin_cos};

use qrm_model::quick_return::Parameters;

use super::PlainFunctions;

/// The equations by hand.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ByHand {
    parameters: Parameters,
    /// J2 + m3 O2A^2
    m11: f64,
    /// J4 + m4 O4G4^2 + m5 O4B^2
    m22: f64,
    /// J5 + m5 BG5^2
    m33: f64,
    /// m5 O4B BG5
    m23: f64,
    /// O2A^2 + O4O2^2
    square: f64,
    /// O2A O4O2
    product: f64,
}

/// Lengths that depend on the position alone.
struct Geometry {
    sin2: f64,
    cos2: f64,
    sin4: f64,
    cos4: f64,
    sin5: f64,
    cos5: f64,
    r: f64,
    inverse_r: f64,
    /// dr/dphi2
    r1: f64,
    jacobian: [[f64; 3]; 2],
}

impl ByHand {
    #[inline(always)]
    fn geometry(&self, q: &[f64; 3]) -> Geometry {
        let p = &self.parameters;
        let [(sin2, cos2), (sin4, cos4), (sin5, cos5)] = q.map(sin_cos);
        let r = (self.square + 2.0 * self.product * sin2).sqrt();
        let inverse_r = 1.0 / r;
        let r1 = self.product * cos2 * inverse_r;
        let jacobian = [[-p.O2A * sin2 - r1 * cos4, r * sin4, 0.0], [0.0, p.O4B * cos4, p.BC * cos5]];
        Geometry { sin2, cos2, sin4, cos4, sin5, cos5, r, inverse_r, r1, jacobian }
    }

    /// T, row by row as in the generated code.
    #[inline]
    pub(crate) fn com_jacobian(&self, &[phi2, phi4, phi5]: &[f64; 3]) -> [[f64; 3]; 10] {
        let p = &self.parameters;
        let [(sin2, cos2), (sin4, cos4), (sin5, cos5)] = [phi2, phi4, phi5].map(sin_cos);
        let b_y = p.O4B * sin4;
        [
            [1.0, 0.0, 0.0],
            [-p.O2A * sin2, 0.0, 0.0],
            [p.O2A * cos2, 0.0, 0.0],
            [0.0, -p.O4G4 * sin4, 0.0],
            [0.0, p.O4G4 * cos4, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, -b_y, -p.BG5 * sin5],
            [0.0, p.O4B * cos4, p.BG5 * cos5],
            [0.0, 0.0, 1.0],
            [0.0, -b_y, -p.BC * sin5],
        ]
    }

    /// (T qd)_q qd, likewise.
    #[inline]
    pub(crate) fn com_bias(&self, &[phi2, phi4, phi5]: &[f64; 3], &[w2, w4, w5]: &[f64; 3]) -> [f64; 10] {
        let p = &self.parameters;
        let [(sin2, cos2), (sin4, cos4), (sin5, cos5)] = [phi2, phi4, phi5].map(sin_cos);
        let (a, g4, b, g5, c) = (p.O2A * w2 * w2, p.O4G4 * w4 * w4, p.O4B * w4 * w4, p.BG5 * w5 * w5, p.BC * w5 * w5);
        let b_x = b * cos4;
        [
            0.0,
            -a * cos2,
            -a * sin2,
            -g4 * cos4,
            -g4 * sin4,
            0.0,
            -b_x - g5 * cos5,
            -b * sin4 - g5 * sin5,
            0.0,
            -b_x - c * cos5,
        ]
    }

    /// C_q.
    #[inline]
    pub(crate) fn constraint_jacobian(&self, q: &[f64; 3]) -> [[f64; 3]; 2] {
        self.geometry(q).jacobian
    }

    /// (C_q qd)_q qd.
    #[inline]
    pub(crate) fn constraint_bias(&self, q: &[f64; 3], qd: &[f64; 3]) -> [f64; 2] {
        self.bias(&self.geometry(q), qd)
    }

    #[inline(always)]
    fn bias(&self, g: &Geometry, &[w2, w4, w5]: &[f64; 3]) -> [f64; 2] {
        let p = &self.parameters;
        let r2 = -(self.product * g.sin2 + g.r1 * g.r1) * g.inverse_r;
        [
            -(p.O2A * g.cos2 + r2 * g.cos4) * w2 * w2 + 2.0 * g.r1 * g.sin4 * w2 * w4 + g.r * g.cos4 * w4 * w4,
            -p.O4B * g.sin4 * w4 * w4 - p.BC * g.sin5 * w5 * w5,
        ]
    }
}

impl PlainFunctions for ByHand {
    fn new(p: Parameters) -> Self {
        Self {
            parameters: p,
            m11: p.J2 + p.m3 * p.O2A * p.O2A,
            m22: p.J4 + p.m4 * p.O4G4 * p.O4G4 + p.m5 * p.O4B * p.O4B,
            m33: p.J5 + p.m5 * p.BG5 * p.BG5,
            m23: p.m5 * p.O4B * p.BG5,
            square: p.O2A * p.O2A + p.O4O2 * p.O4O2,
            product: p.O2A * p.O4O2,
        }
    }

    #[inline(always)]
    fn dynamics(&self, q: &[f64; 3], qd: &[f64; 3]) -> Dynamics<f64, 3, 2> {
        let (p, [_, w4, w5]) = (&self.parameters, *qd);
        let g = self.geometry(q);
        let (b_y, c_y) = (p.O4B * g.sin4, p.BC * g.sin5);
        let coupling = self.m23 * (g.cos4 * g.cos5 + g.sin4 * g.sin5) + p.m6 * b_y * c_y;
        let ram = p.F6 + p.m6 * (p.O4B * g.cos4 * w4 * w4 + p.BC * g.cos5 * w5 * w5);
        let turning = self.m23 * (g.sin4 * g.cos5 - g.cos4 * g.sin5);
        Dynamics {
            mass_matrix: [
                [self.m11, 0.0, 0.0],
                [0.0, self.m22 + p.m6 * b_y * b_y, coupling],
                [0.0, coupling, self.m33 + p.m6 * c_y * c_y],
            ],
            generalized_forces: [0.0, -turning * w5 * w5 - b_y * ram, turning * w4 * w4 - c_y * ram],
            constraint_jacobian: g.jacobian,
            constraint_bias: self.bias(&g, qd),
        }
    }

    #[inline(always)]
    fn loop_constraints(&self, q: &[f64; 3]) -> LoopConstraints<f64, 3, 2> {
        let p = &self.parameters;
        let g = self.geometry(q);
        LoopConstraints {
            residuals: [p.O2A * g.cos2 - g.r * g.cos4, p.O4B * g.sin4 + p.BC * g.sin5 - p.yC],
            constraint_jacobian: g.jacobian,
            constraint_rate: [0.0; 2],
        }
    }
}
