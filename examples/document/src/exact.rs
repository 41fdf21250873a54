//! The exact motion, from the integral of energy.
//!
//! The mechanism has one degree of freedom and its energy is constant, so the rate of the crank is a function of its
//! angle. The time is then an integral over the angle. No equation of motion is integrated.

use nalgebra::Vector3;
use qrm_model::quick_return::QuickReturn;

use crate::motion::{Row, jacobian, total_energy};

/// Abscissae and weights of the Gauss-Legendre formula with five points on [-1, 1].
const GAUSS_LEGENDRE: [(f64, f64); 5] = [
    (-0.906_179_845_938_664, 0.236_926_885_056_189_08),
    (-0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.0, 0.568_888_888_888_888_9),
    (0.538_469_310_105_683_1, 0.478_628_670_499_366_47),
    (0.906_179_845_938_664, 0.236_926_885_056_189_08),
];
/// The largest change of time that one application of the formula covers, in s.
const MAX_INTERVAL: f64 = 1e-3;

/// The mechanism on the level of energy where it starts.
pub struct EnergyIntegral<'m> {
    mechanism: &'m QuickReturn,
    energy: f64,
}

impl<'m> EnergyIntegral<'m> {
    /// The energy of the start that the scene asks for.
    pub fn new(mechanism: &'m QuickReturn) -> Result<Self, String> {
        let integral = Self { mechanism, energy: 0.0 };
        let (q, qd) = integral.start();
        let energy = total_energy(mechanism, &q, &qd);
        if energy.is_finite() { Ok(Self { energy, ..integral }) } else { Err("the mechanism has no start".into()) }
    }

    /// The state at `t = 0`.
    pub fn start(&self) -> (Vector3<f64>, Vector3<f64>) {
        let q = self.configuration(0.0);
        (q, self.mechanism.parameters().w0 * self.direction(&q))
    }

    /// The angles where the crank is at `phi2`, by the geometry of the two loops.
    fn configuration(&self, phi2: f64) -> Vector3<f64> {
        let p = self.mechanism.parameters();
        let phi4 = (p.O4O2 + p.O2A * phi2.sin()).atan2(p.O2A * phi2.cos());
        let phi5 = std::f64::consts::PI - ((p.yC - p.O4B * phi4.sin()) / p.BC).asin();
        Vector3::new(phi2, phi4, phi5)
    }

    /// The rates where the crank turns with a rate of one.
    fn direction(&self, q: &Vector3<f64>) -> Vector3<f64> {
        let c = jacobian(self.mechanism, q);
        // The slot does not contain phi5, and the guide does not contain phi2.
        let phi4_dot = -c[(0, 0)] / c[(0, 1)];
        Vector3::new(1.0, phi4_dot, -c[(1, 1)] * phi4_dot / c[(1, 2)])
    }

    /// The state where the crank is at `phi2`.
    pub fn state(&self, phi2: f64) -> (Vector3<f64>, Vector3<f64>) {
        let q = self.configuration(phi2);
        let direction = self.direction(&q);
        let potential = total_energy(self.mechanism, &q, &Vector3::zeros());
        let unit = total_energy(self.mechanism, &q, &direction) - potential;
        (q, ((self.energy - potential) / unit).sqrt() * direction)
    }

    /// The time that the crank takes from one angle to another one nearby.
    pub fn time_between(&self, from: f64, to: f64) -> f64 {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        let slowness = |x: f64| self.state(middle + half * x).1[0].recip();
        half * GAUSS_LEGENDRE.iter().map(|(x, weight)| weight * slowness(*x)).sum::<f64>()
    }

    /// The angle of the crank `h` after it was at `phi2`.
    fn angle_after(&self, phi2: f64, h: f64) -> f64 {
        let pieces = (h / MAX_INTERVAL).ceil().max(1.0);
        let mut from = phi2;
        for _ in 0..pieces as u32 {
            let mut to = from + h / pieces * self.state(from).1[0];
            // Newton's method: it converges to rounding errors in three iterations.
            for _ in 0..4 {
                to += (h / pieces - self.time_between(from, to)) * self.state(to).1[0];
            }
            from = to;
        }
        from
    }

    /// The exact rows at the given times, the first of which is zero.
    pub fn rows(&self, times: impl Iterator<Item = f64>) -> Result<Vec<Row>, String> {
        let (mut t_before, mut phi2) = (0.0, 0.0);
        let row = |t: f64| {
            phi2 = self.angle_after(phi2, t - t_before);
            t_before = t;
            let (q, qd) = self.state(phi2);
            Row::from_state(self.mechanism, t, q, qd)
        };
        times.map(row).collect()
    }
}
