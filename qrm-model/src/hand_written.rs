//! The quick-return mechanism with its algebra done on paper, as a good engineer would write it: for comparison with
//! the generated code, in numbers and in speed.
//!
//! With `r` the distance O4-A, the slot closes as `C1 = O2A cos(phi2) - r cos(phi4)`, where
//! `r^2 = O2A^2 + O4O2^2 + 2 O2A O4O2 sin(phi2)` and so `r' = O2A O4O2 cos(phi2) / r`. Gravity, torque on the crank and
//! inertia of the block are left out, as they are in the scene.

use qrm_mechanism::{Closure, Description, Dynamics, Lane, Mechanism, Schedule, Start};

use crate::quick_return::{Parameters, QuickReturn};

/// The quick-return mechanism with dynamics and closure by hand; the rest is taken from the generated code.
#[derive(Clone, Copy, Debug)]
pub struct HandWritten {
    generated: QuickReturn,
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

impl HandWritten {
    /// The mechanism with these parameters.
    pub fn new(parameters: Parameters) -> Self {
        let p = parameters;
        Self {
            generated: QuickReturn::new(p),
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
    fn geometry(&self, q: &[f64; 3]) -> Geometry {
        let p = &self.parameters;
        let [(sin2, cos2), (sin4, cos4), (sin5, cos5)] = q.map(f64::sin_cos);
        let r = (self.square + 2.0 * self.product * sin2).sqrt();
        let inverse_r = 1.0 / r;
        let r1 = self.product * cos2 * inverse_r;
        let jacobian = [[-p.O2A * sin2 - r1 * cos4, r * sin4, 0.0], [0.0, p.O4B * cos4, p.BC * cos5]];
        Geometry { sin2, cos2, sin4, cos4, sin5, cos5, r, inverse_r, r1, jacobian }
    }
}

impl Mechanism<3, 2> for HandWritten {
    type Kernel<R: Lane> = QuickReturn<R>;

    const DESCRIPTION: Description = QuickReturn::<f64>::DESCRIPTION;

    fn with_parameters(replace: &dyn Fn(&str) -> Option<f64>) -> Self {
        Self::new(Parameters::with(replace))
    }

    #[inline(always)]
    fn dynamics(&self, _t: f64, q: &[f64; 3], &[w2, w4, w5]: &[f64; 3]) -> Dynamics<f64, 3, 2> {
        let p = &self.parameters;
        let g = self.geometry(q);
        let (b_y, c_y) = (p.O4B * g.sin4, p.BC * g.sin5);
        let coupling = self.m23 * (g.cos4 * g.cos5 + g.sin4 * g.sin5) + p.m6 * b_y * c_y;
        let ram = p.F6 + p.m6 * (p.O4B * g.cos4 * w4 * w4 + p.BC * g.cos5 * w5 * w5);
        let turning = self.m23 * (g.sin4 * g.cos5 - g.cos4 * g.sin5);
        let r2 = -(self.product * g.sin2 + g.r1 * g.r1) * g.inverse_r;
        Dynamics {
            mass_matrix: [
                [self.m11, 0.0, 0.0],
                [0.0, self.m22 + p.m6 * b_y * b_y, coupling],
                [0.0, coupling, self.m33 + p.m6 * c_y * c_y],
            ],
            generalized_forces: [0.0, -turning * w5 * w5 - b_y * ram, turning * w4 * w4 - c_y * ram],
            constraint_jacobian: g.jacobian,
            constraint_bias: [
                -(p.O2A * g.cos2 + r2 * g.cos4) * w2 * w2 + 2.0 * g.r1 * g.sin4 * w2 * w4 + g.r * g.cos4 * w4 * w4,
                -b_y * w4 * w4 - c_y * w5 * w5,
            ],
        }
    }

    #[inline(always)]
    fn closure(&self, q: &[f64; 3]) -> Closure<f64, 3, 2> {
        let p = &self.parameters;
        let g = self.geometry(q);
        Closure {
            constraints: [p.O2A * g.cos2 - g.r * g.cos4, p.O4B * g.sin4 + p.BC * g.sin5 - p.yC],
            constraint_jacobian: g.jacobian,
        }
    }

    fn visit_parameters(&self, visit: &mut dyn FnMut(f64)) {
        self.generated.visit_parameters(visit);
    }

    fn start(&self) -> Start<3> {
        self.generated.start()
    }

    fn schedule(&self) -> Schedule {
        self.generated.schedule()
    }

    fn stop(&self, t: f64, q: &[f64; 3], qd: &[f64; 3]) -> Option<f64> {
        self.generated.stop(t, q, qd)
    }

    fn mass_matrix(&self, q: &[f64; 3]) -> [[f64; 3]; 3] {
        self.dynamics(0.0, q, &[0.0; 3]).mass_matrix
    }

    fn energy(&self, q: &[f64; 3], qd: &[f64; 3]) -> [f64; 2] {
        self.generated.energy(q, qd)
    }

    fn power(&self, t: f64, q: &[f64; 3], qd: &[f64; 3]) -> f64 {
        self.generated.power(t, q, qd)
    }

    fn outputs(
        &self,
        t: f64,
        q: &[f64; 3],
        qd: &[f64; 3],
        qdd: &[f64; 3],
        multipliers: &[f64; 2],
        outputs: &mut [f64],
    ) {
        Mechanism::outputs(&self.generated, t, q, qd, qdd, multipliers, outputs);
    }
}
