//! The motion of a conservative mechanism with one degree of freedom, without integration of its equations of motion:
//! the rate follows from the energy, the position from the constraints, the time from a quadrature.

use qrm_core::Mechanism;

use crate::position::{LoopSolver, Position, Start, assemble};
use crate::quadrature::{NODES, gauss_legendre};

/// The number of panels in a turn, or in a unit of length. The results of the two numbers differ by rounding errors.
pub const PANELS: [f64; 2] = [96.0, 67.0];
/// Random rates at which loads without a potential are searched for.
const PROBE_RATES: [f64; 3] = [1.0, -0.7, 2.3];
/// The number of times, less one, at which loads are tested with each of these rates: a load may act for a short time
/// only.
const PROBE_TIMES: u32 = 256;

/// Times at equally spaced values of the driven coordinate.
#[derive(Clone)]
pub struct EnergyIntegral<'m> {
    drive: LoopSolver<'m>,
    driven: usize,
    energy: f64,
    /// The width of a panel, with the sign of the direction in which the driven coordinate moves.
    step: f64,
    panels: Vec<Panel>,
    rule: [(f64, f64); NODES],
}

#[derive(Clone, Debug)]
struct Panel {
    begin: Position,
    /// The time at its beginning, and the rounding error of that.
    t: (f64, f64),
}

/// The reason why there is no such integral.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoEnergyIntegral {
    /// The number of coordinates given at the scene's start is not one.
    NotOneGiven,
    /// Some load has no potential, or depends on time.
    NotConservative,
    /// Constraints depend on time.
    Driven,
    /// The motion reverses or stops, or the mechanism locks.
    TurnsBack,
}

impl<'m> EnergyIntegral<'m> {
    /// Follows the motion of the scene until a time, with this number of panels in a turn.
    ///
    /// # Errors
    /// The motion has no energy integral.
    pub fn new(mechanism: &'m dyn Mechanism, until: f64, panels: f64) -> Result<Self, NoEnergyIntegral> {
        if mechanism.is_driven() {
            return Err(NoEnergyIntegral::Driven);
        }
        let start = Start::new(mechanism);
        let mut places = (0..start.given.len()).filter(|&i| start.given[i]);
        let (Some(driven), None) = (places.next(), places.next()) else {
            return Err(NoEnergyIntegral::NotOneGiven);
        };
        let drive = LoopSolver::new(mechanism, start.given.clone()).ok_or(NoEnergyIntegral::NotOneGiven)?;
        let (q, qd) = assemble(mechanism, Start::new(mechanism)).map_err(|_| NoEnergyIntegral::TurnsBack)?;
        let begin = drive.solve_loops(q).ok_or(NoEnergyIntegral::TurnsBack)?;
        let step = qd[driven].signum() * std::f64::consts::TAU / panels;
        if qd[driven] == 0.0 {
            return Err(NoEnergyIntegral::TurnsBack);
        }
        let rates = scaled(&drive.tangent(&begin, driven), qd[driven]);
        let energy = mechanism.energy(&begin.q, &rates).iter().sum();
        let rule = gauss_legendre();
        let mut integral = Self { drive, driven, energy, step, panels: vec![Panel { begin, t: (0.0, 0.0) }], rule };
        while integral.last().t.0 <= until {
            let Panel { begin, t } = integral.last().clone();
            integral.check(&begin, until)?;
            // Positions are computed from the start: a sum of steps would accumulate rounding errors.
            let to = integral.panels[0].begin.q[driven] + step * integral.panels.len() as f64;
            let step = to - begin.q[driven];
            let end = integral.moved(&begin, step).ok_or(NoEnergyIntegral::TurnsBack)?;
            let duration = integral.duration(&begin, step).ok_or(NoEnergyIntegral::TurnsBack)?;
            // Compensated summation: the rounding errors of many panels would accumulate.
            let (sum, rest) = (t.0 + duration, t.1);
            let rest = rest + if t.0 >= duration { (t.0 - sum) + duration } else { (duration - sum) + t.0 };
            integral.panels.push(Panel { begin: end, t: (sum, rest) });
        }
        Ok(integral)
    }

    fn last(&self) -> &Panel {
        &self.panels[self.panels.len() - 1]
    }

    /// The time at which the driven coordinate has changed by `change` in its direction, accurate to rounding errors.
    pub fn time_of(&self, change: f64) -> Option<f64> {
        let place = (change / self.step.abs()) as usize;
        let panel = self.panels.get(place)?;
        let rest = self.panels[0].begin.q[self.driven] + change * self.step.signum() - panel.begin.q[self.driven];
        Some(panel.t.0 + (panel.t.1 + self.duration(&panel.begin, rest)?))
    }

    /// Coordinates and rates at a time.
    pub fn state(&self, t: f64) -> Option<(Vec<f64>, Vec<f64>)> {
        let after = self.panels.partition_point(|panel| panel.t.0 <= t);
        let panel = &self.panels[after.checked_sub(1)?];
        // Newton's method for the position at this time.
        let wanted = (t - panel.t.0) - panel.t.1;
        let mut change = wanted * self.rate(&panel.begin)?;
        for _ in 0..20 {
            let at = self.moved(&panel.begin, change)?;
            let correction = (wanted - self.duration(&panel.begin, change)?) * self.rate(&at)?;
            change += correction;
            if correction.abs() <= 1e-16 * self.step.abs() {
                break;
            }
        }
        let at = self.moved(&panel.begin, change)?;
        let rate = self.rate(&at)?;
        let rates = scaled(&self.drive.tangent(&at, self.driven), rate);
        Some((at.q, rates))
    }

    /// The time that a change of the driven coordinate takes from a position.
    fn duration(&self, from: &Position, change: f64) -> Option<f64> {
        let mut sum = 0.0;
        for (node, weight) in self.rule {
            let at = self.moved(from, change * node)?;
            sum += weight / self.rate(&at)?;
        }
        Some(sum * change)
    }

    /// The rate of the driven coordinate from the energy at a position; `None` if the motion cannot reach the position.
    fn rate(&self, at: &Position) -> Option<f64> {
        let tangent = self.drive.tangent(at, self.driven);
        let [inertia, potential] = self.drive.mechanism.energy(&at.q, &tangent);
        let square = (self.energy - potential) / inertia;
        (square > 0.0 && square.is_finite()).then(|| square.sqrt() * self.step.signum())
    }

    fn moved(&self, from: &Position, change: f64) -> Option<Position> {
        let mut target = from.q.clone();
        target[self.driven] += change;
        self.drive.move_to(from, &target).ok()
    }

    /// Checks that no load without a potential acts at any of the random rates.
    fn check(&self, at: &Position, until: f64) -> Result<(), NoEnergyIntegral> {
        let tangent = self.drive.tangent(at, self.driven);
        let mechanism = self.drive.mechanism;
        let description = mechanism.description();
        let (still, multipliers) = (vec![0.0; at.q.len()], vec![0.0; description.constraints.len()]);
        let works = |t: f64, rate: f64| mechanism.power(t, &at.q, &scaled(&tangent, rate), &still, &multipliers) != 0.0;
        let mut times = (0..=PROBE_TIMES).map(|k| until * f64::from(k) / f64::from(PROBE_TIMES));
        if !description.friction.is_empty() || times.any(|t| PROBE_RATES.into_iter().any(|rate| works(t, rate))) {
            Err(NoEnergyIntegral::NotConservative)
        } else {
            Ok(())
        }
    }
}

fn scaled(x: &[f64], factor: f64) -> Vec<f64> {
    x.iter().map(|x| x * factor).collect()
}
