//! A full turn of a driven angle, slowly: where everything is, what it takes to hold it, where it locks.

use std::f64::consts::TAU;

use qrm_mechanism::Mechanism;

use crate::assembly::{NotAssembled, assemble};
use crate::kinematics::{Drive, Lock, Position};

/// Positions in a turn.
const SAMPLES: usize = 720;

/// What a turn shows.
#[derive(Clone, Debug)]
pub struct Turn {
    /// The driven coordinate.
    pub coordinate: usize,
    /// From the start on, in the direction in which the scene starts; one more than a turn has if it comes round.
    pub samples: Vec<Sample>,
    /// What keeps it from turning fully.
    pub range: Option<Range>,
    /// Where it is nearest to locking, and its margin there, between 0 and 1.
    pub nearest: (f64, f64),
    /// Whether all coordinates come back after a turn, angles up to whole turns.
    pub returns: bool,
}

/// A position at rest.
#[derive(Clone, Debug)]
pub struct Sample {
    /// The driven coordinate.
    pub angle: f64,
    /// The generalized force on it that balances the loads.
    pub balance: f64,
    /// The outputs, without motion.
    pub outputs: Vec<f64>,
}

/// Between which values a driven coordinate can move, and the constraint that ends its way there.
#[derive(Clone, Copy, Debug)]
pub struct Range {
    /// The smallest value.
    pub low: (f64, Option<usize>),
    /// The largest value.
    pub high: (f64, Option<usize>),
}

/// Why there is nothing to turn.
#[derive(Clone, Debug, PartialEq)]
pub enum NoTurn {
    /// The mechanism has another number of freedoms than one.
    Freedoms(usize),
    /// The start is a singular position.
    Singular,
    /// What is given at the start is no angle.
    NotAnAngle(usize),
    /// The constraints cannot be met at the start.
    NotAssembled(NotAssembled),
}

/// Turns the driven coordinate once around.
///
/// # Errors
/// There is nothing to turn.
pub fn turn<X: Mechanism<N, M>, const N: usize, const M: usize>(mechanism: &X) -> Result<Turn, NoTurn> {
    let round = Round::new(mechanism)?;
    let driven = round.driven;
    let mut samples = vec![round.sample(&round.start)];
    let walked = round.walk(round.way, SAMPLES, |position| samples.push(round.sample(position)));
    let (range, nearest, returns) = match walked {
        Ok((end, nearest)) => {
            let comes_back = |i: usize| {
                let turned = end.q[i] - round.start.q[i];
                let is_angle = X::DESCRIPTION.coordinates[i].unit == "rad";
                (if is_angle { turned - TAU * (turned / TAU).round() } else { turned }).abs() < 1e-9
            };
            (None, nearest, (0..N).all(comes_back))
        }
        Err(ahead) => {
            let mut behind = Vec::new();
            let back = round.walk(-round.way, SAMPLES, |position| behind.push(round.sample(position)));
            let back = back.err().unwrap_or(ahead);
            behind.push(round.sample(&back.position));
            behind.reverse();
            samples.push(round.sample(&ahead.position));
            samples.splice(0..0, behind);
            let end = |lock: &Lock<N>| (lock.position.q[driven], lock.constraint);
            let (low, high) = if round.way > 0.0 { (end(&back), end(&ahead)) } else { (end(&ahead), end(&back)) };
            (Some(Range { low, high }), (ahead.position.q[driven], 0.0), false)
        }
    };
    Ok(Turn { coordinate: driven, samples, range, nearest, returns })
}

/// Whether the driven coordinate can turn fully.
pub fn turns<X: Mechanism<N, M>, const N: usize, const M: usize>(mechanism: &X) -> bool {
    Round::new(mechanism).is_ok_and(|round| round.walk(round.way, SAMPLES / 4, |_| ()).is_ok())
}

/// A turn to be made.
struct Round<'m, X, const N: usize, const M: usize> {
    drive: Drive<'m, X, N, M>,
    start: Position<N>,
    driven: usize,
    /// 1 or -1.
    way: f64,
}

impl<'m, X: Mechanism<N, M>, const N: usize, const M: usize> Round<'m, X, N, M> {
    fn new(mechanism: &'m X) -> Result<Self, NoTurn> {
        let start = mechanism.start();
        let freedoms = start.given.iter().filter(|given| **given).count();
        let (1, Some(driven)) = (freedoms, start.given.iter().position(|given| *given)) else {
            return Err(NoTurn::Freedoms(freedoms));
        };
        if X::DESCRIPTION.coordinates[driven].unit != "rad" {
            return Err(NoTurn::NotAnAngle(driven));
        }
        let drive = Drive::new(mechanism, start.given).ok_or(NoTurn::Freedoms(N.saturating_sub(M)))?;
        let (q, qd) = assemble(mechanism, &start).map_err(NoTurn::NotAssembled)?;
        let way = if qd[driven] < 0.0 { -1.0 } else { 1.0 };
        let start = drive.close(q).ok_or(NoTurn::Singular)?;
        Ok(Self { drive, start, driven, way })
    }

    /// Goes once around, one way or the other, and says where it ends and where the margin was smallest.
    fn walk(
        &self,
        way: f64,
        samples: usize,
        mut visit: impl FnMut(&Position<N>),
    ) -> Result<(Position<N>, (f64, f64)), Lock<N>> {
        let mut last = [self.start; 3];
        let mut nearest = (self.start.q[self.driven], self.start.margin.abs());
        // One step more, so that a smallest margin at the start is between two others as well.
        for i in 1..=samples + 1 {
            let mut target = self.start.q;
            target[self.driven] += way * TAU * i as f64 / samples as f64;
            let next = self.drive.go(&last[2], &target)?;
            last = [last[1], last[2], next];
            let [before, at, after] = last.map(|position| position.margin.abs());
            if i > 1 && at <= before && at <= after {
                let found = self.smallest_margin(last[0], &last[2])?;
                if found.1 < nearest.1 {
                    nearest = found;
                }
            }
            if i <= samples {
                visit(&next);
            }
        }
        Ok((last[1], nearest))
    }

    /// The smallest margin between two positions, by golden sections.
    fn smallest_margin(&self, from: Position<N>, to: &Position<N>) -> Result<(f64, f64), Lock<N>> {
        let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
        let at = |angle: f64| {
            let mut target = from.q;
            target[self.driven] = angle;
            self.drive.go(&from, &target)
        };
        let (mut a, mut b) = (from.q[self.driven], to.q[self.driven]);
        let (mut c, mut d) = (b - golden * (b - a), a + golden * (b - a));
        let (mut at_c, mut at_d) = (at(c)?, at(d)?);
        while (b - a).abs() > 1e-9 {
            if at_c.margin.abs() < at_d.margin.abs() {
                (b, d, at_d) = (d, c, at_c);
                c = b - golden * (b - a);
                at_c = at(c)?;
            } else {
                (a, c, at_c) = (c, d, at_d);
                d = a + golden * (b - a);
                at_d = at(d)?;
            }
        }
        Ok((at_c.q[self.driven], at_c.margin.abs()))
    }

    fn sample(&self, position: &Position<N>) -> Sample {
        let (multipliers, forces) = self.drive.balance(&position.q);
        let mut outputs = vec![0.0; X::DESCRIPTION.outputs.len()];
        self.drive.mechanism.outputs(0.0, &position.q, &[0.0; N], &[0.0; N], &multipliers, &mut outputs);
        Sample { angle: position.q[self.driven], balance: forces[self.driven], outputs }
    }
}
