//! The step's equations as well as a hand can write them: products of parameters taken out, one independent coordinate,
//! every quotient computed once.

use qrm_core::{
    Angles, Description, Dynamics, Equations, Generated, Kernel, LoopConstraints, Scalar, Schedule, Start, StoredTape,
    copy_outputs,
};
use qrm_model::quick_return::{Parameters, QuickReturn};

/// The equations in the order a step needs them.
#[derive(Clone, Copy, Debug)]
pub(crate) struct KernelByHand<R> {
    generated: QuickReturn<R>,
    p: Parameters<R>,
    m11: R,
    m22: R,
    m33: R,
    m23: R,
    square: R,
    product: R,
    twice: R,
}

/// The values that follow from the position alone.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place<R> {
    r: R,
    inv_r: R,
    r1: R,
    a_x: R,
    b_x: R,
    b_y: R,
    c_x: R,
    c_y: R,
    /// -C_1 by phi2, C_1 by phi4.
    slot: [R; 2],
    inv_slot: R,
    inv_guide: R,
    open: [R; 2],
    m22: R,
    m33: R,
    m23: R,
    /// Rates of rocker and rod for a unit rate of the crank.
    k4: R,
    k5: R,
    /// Momenta of rocker and rod for the same.
    u4: R,
    u5: R,
    inv_inertia: R,
}

impl<R: Scalar> KernelByHand<R> {
    /// Changes of all coordinates from those of the loops and a drive of the crank.
    #[inline(always)]
    fn combine(&self, at: &Place<R>, slot: R, guide: R, drive: R) -> [R; 3] {
        let p4 = slot * at.inv_slot;
        let p5 = at.inv_guide * p4.neg_mul_add(at.b_x, guide);
        let x2 = at.inv_inertia * at.u5.neg_mul_add(p5, at.u4.neg_mul_add(p4, drive));
        [x2, at.k4.mul_add(x2, p4), at.k5.mul_add(x2, p5)]
    }
}

impl<R: Scalar> Kernel<R, 3, 2> for KernelByHand<R> {
    type Position = Place<R>;

    const OPERATIONS: usize = 107;

    #[inline(always)]
    fn has_angle(&self) -> [bool; 3] {
        [true; 3]
    }

    #[inline(always)]
    fn is_length(&self) -> [bool; 3] {
        [false; 3]
    }

    #[inline(always)]
    fn set_values(&mut self, value: &dyn Fn(usize) -> R) {
        *self = Self::with_values(value);
    }

    #[inline(always)]
    fn position(&self, _: R, _: &[R; 3], angles: &Angles<R, 3>) -> Place<R> {
        let p = &self.p;
        let ([s2, s4, s5], [c2, c4, c5]) = (angles.sin, angles.cos);
        let r_sq = self.twice.mul_add(s2, self.square);
        let r = r_sq.sqrt();
        // Beside the root, not behind it.
        let inv_r = r_sq.recip() * r;
        let r1 = self.product * c2 * inv_r;
        let (a_x, b_x, b_y, c_x, c_y) = (p.O2A * c2, p.O4B * c4, p.O4B * s4, p.BC * c5, p.BC * s5);
        let slot = [c4.mul_add(r1, p.O2A * s2), r * s4];
        let (b, c) = (p.m6 * b_y, p.m6 * c_y);
        let m22 = b.mul_add(b_y, self.m22);
        let m33 = c.mul_add(c_y, self.m33);
        let m23 = b.mul_add(c_y, self.m23 * c4.mul_add(c5, s4 * s5));
        let (inv_slot, inv_guide) = (s4.recip() * inv_r, c_x.recip());
        let k4 = slot[0] * inv_slot;
        let k5 = -(b_x * inv_guide * k4);
        let u4 = m22.mul_add(k4, m23 * k5);
        let u5 = m23.mul_add(k4, m33 * k5);
        let inv_inertia = k4.mul_add(u4, k5.mul_add(u5, self.m11)).recip();
        let open = [c4.neg_mul_add(r, a_x), b_y - p.yC + c_y];
        Place {
            r,
            inv_r,
            r1,
            a_x,
            b_x,
            b_y,
            c_x,
            c_y,
            slot,
            inv_slot,
            inv_guide,
            open,
            m22,
            m33,
            m23,
            k4,
            k5,
            u4,
            u5,
            inv_inertia,
        }
    }

    #[inline(always)]
    fn residuals(&self, at: &Place<R>) -> [R; 2] {
        at.open
    }

    #[inline(always)]
    fn growth_factor(&self, at: &Place<R>) -> R {
        at.k4.abs().max(at.k5.abs())
    }

    #[inline(always)]
    fn velocity_residual(&self, at: &Place<R>, &[w2, w4, w5]: &[R; 3]) -> [R; 2] {
        [at.slot[0].neg_mul_add(w2, at.slot[1] * w4), at.b_x.mul_add(w4, at.c_x * w5)]
    }

    #[inline(always)]
    fn correction(&self, at: &Place<R>, &[slot, guide]: &[R; 2]) -> [R; 3] {
        self.combine(at, slot, guide, R::zero()).map(|x| -x)
    }

    #[inline(always)]
    fn accelerations(
        &self,
        at: &Place<R>,
        _: R,
        _: &[R; 3],
        &[w2, w4, w5]: &[R; 3],
        angles: &Angles<R, 3>,
    ) -> ([R; 3], [R; 2]) {
        let ([s2, s4, s5], [_, c4, c5]) = (angles.sin, angles.cos);
        let (w22, w44, w55) = (w2 * w2, w4 * w4, w5 * w5);
        let ram = self.p.m6.mul_add(at.b_x.mul_add(w44, at.c_x * w55), self.p.F6);
        let turning = self.m23 * c4.neg_mul_add(s5, s4 * c5);
        let f4 = -turning.mul_add(w55, at.b_y * ram);
        let f5 = at.c_y.neg_mul_add(ram, turning * w44);
        let r_dot = at.r1 * w2;
        let inward = at.r.mul_add(w44, at.inv_r * r_dot.mul_add(r_dot, self.product * s2 * w22));
        let slot = c4.neg_mul_add(inward, (r_dot + r_dot).neg_mul_add(s4 * w4, at.a_x * w22));
        let guide = at.b_y.mul_add(w44, at.c_y * w55);
        let qdd = self.combine(at, slot, guide, at.k4.mul_add(f4, at.k5 * f5));
        let [_, a4, a5] = qdd;
        let guide = at.inv_guide * at.m33.neg_mul_add(a5, at.m23.neg_mul_add(a4, f5));
        let slot = at.inv_slot * at.b_x.neg_mul_add(guide, at.m23.neg_mul_add(a5, at.m22.neg_mul_add(a4, f4)));
        (qdd, [slot, guide])
    }

    #[inline(always)]
    fn event(&self, t: R, q: &[R; 3], qd: &[R; 3], qdd: &[R; 3], multipliers: &[R; 2]) -> Option<R> {
        self.generated.event(t, q, qd, qdd, multipliers)
    }

    #[inline(always)]
    fn outputs_at(
        &self,
        at: &Place<R>,
        _: R,
        _: &[R; 3],
        &[w2, w4, w5]: &[R; 3],
        angles: &Angles<R, 3>,
        &[_, a4, a5]: &[R; 3],
        &[slot, guide]: &[R; 2],
        outputs: &mut [R],
    ) {
        let values = [
            at.b_x + at.c_x,
            -at.b_y.mul_add(w4, at.c_y * w5),
            -at.b_y.mul_add(a4, at.c_y.mul_add(a5, (at.b_x * w4).mul_add(w4, at.c_x * w5 * w5))),
            at.r1 * w2,
            slot * angles.sin[1],
            -guide,
        ];
        copy_outputs(&values, outputs);
    }

    fn power(&self, t: R, q: &[R; 3], qd: &[R; 3], qdd: &[R; 3], multipliers: &[R; 2]) -> R {
        self.generated.power(t, q, qd, qdd, multipliers)
    }
}

impl<R: Scalar> Equations<R, 3, 2> for KernelByHand<R> {
    fn with_values(value: &dyn Fn(usize) -> R) -> Self {
        let generated = QuickReturn::with_values(value);
        let p = *generated.parameters();
        let product = p.O2A * p.O4O2;
        Self {
            generated,
            p,
            m11: p.J2 + p.m3 * p.O2A * p.O2A,
            m22: p.J4 + p.m4 * p.O4G4 * p.O4G4 + p.m5 * p.O4B * p.O4B,
            m33: p.J5 + p.m5 * p.BG5 * p.BG5,
            m23: p.m5 * p.O4B * p.BG5,
            square: p.O2A * p.O2A + p.O4O2 * p.O4O2,
            product,
            twice: product + product,
        }
    }

    fn start(&self) -> Start<R, 3> {
        self.generated.start()
    }

    fn schedule(&self) -> Schedule<R> {
        self.generated.schedule()
    }

    fn dynamics(&self, t: R, q: &[R; 3], qd: &[R; 3]) -> Dynamics<R, 3, 2> {
        self.generated.dynamics(t, q, qd)
    }

    fn loop_constraints(&self, t: R, q: &[R; 3]) -> LoopConstraints<R, 3, 2> {
        self.generated.loop_constraints(t, q)
    }

    fn mass_matrix(&self, q: &[R; 3]) -> [[R; 3]; 3] {
        self.generated.mass_matrix(q)
    }

    fn energy(&self, q: &[R; 3], qd: &[R; 3]) -> [R; 2] {
        self.generated.energy(q, qd)
    }

    fn outputs(&self, t: R, q: &[R; 3], qd: &[R; 3], qdd: &[R; 3], multipliers: &[R; 2], outputs: &mut [R]) {
        self.generated.outputs(t, q, qd, qdd, multipliers, outputs);
    }
}

/// The mechanism with the kernel by hand; the rest is generated.
#[derive(Debug)]
pub(crate) struct HandWritten;

impl Generated<3, 2> for HandWritten {
    type Kernel<R: Scalar> = KernelByHand<R>;

    const DESCRIPTION: &'static Description = QuickReturn::<f64>::DESCRIPTION;
    const TAPE: &'static StoredTape = QuickReturn::<f64>::TAPE;
    const LANE_STEPS: qrm_core::LaneStepsTable = LANE_STEPS;
}

qrm_core::lane_steps!(HandWritten, 3, 2);
