//! The states that satisfy the constraints.

use qrm_core::{Interval, Obstacle, Tape, TapeSeries};

use super::matrix::IntervalMatrix;

/// The constraints of states: `C = 0` and `C_q qd + C_t = 0`.
pub(super) struct Manifold {
    coordinates: usize,
    constraints: usize,
    /// The tape's `loop_constraints`, with derivatives with respect to the coordinates.
    series: TapeSeries,
}

/// The constraints in a box of states.
pub(super) struct Linearized {
    /// The residuals of `C`, then those of its rate.
    pub(super) residuals: Vec<Interval>,
    /// The derivatives of the residuals with respect to the coordinates, then to the rates.
    pub(super) jacobian: IntervalMatrix,
}

impl Manifold {
    /// Creates the constraints of a tape, with some parameters replaced by index.
    pub(super) fn new(tape: &Tape, replace: &dyn Fn(usize) -> Option<Interval>) -> Self {
        let (n, m) = (tape.coordinates as usize, tape.constraints as usize);
        let series = TapeSeries::new(tape, &tape.loop_constraints, replace, [0, n]);
        Self { coordinates: n, constraints: m, series }
    }

    /// The numbers of coordinates and of constraints.
    pub(super) fn sizes(&self) -> [usize; 2] {
        [self.coordinates, self.constraints]
    }

    /// The operation without a finite value in the last box.
    pub(super) fn obstacle(&self) -> Option<Obstacle> {
        self.series.obstacle()
    }

    /// Evaluates the constraints in an interval of time and a box of states.
    pub(super) fn linearized(&mut self, t: Interval, state: &[Interval]) -> Linearized {
        let [n, m] = self.sizes();
        let (q, qd) = state.split_at(n);
        let mut argument = vec![Interval::ZERO; 1 + n];
        argument[0] = t;
        self.series.set(0, 0, &argument);
        for (i, q) in q.iter().enumerate() {
            argument.fill(Interval::ZERO);
            argument[0] = *q;
            argument[1 + i] = Interval::ONE;
            self.series.set(0, 1 + i, &argument);
        }
        self.series.advance(0);
        let result = |i: usize| self.series.result(0, i);
        // The rates of the constraints and their derivatives.
        let rates: Vec<Vec<Interval>> = (0..m)
            .map(|k| {
                qd.iter().enumerate().fold(result(m + m * n + k).to_vec(), |rate, (i, qd)| {
                    rate.iter().zip(result(m + k * n + i)).map(|(rate, entry)| *rate + *entry * *qd).collect()
                })
            })
            .collect();
        let residuals = (0..m).map(|k| result(k)[0]).chain(rates.iter().map(|rate| rate[0])).collect();
        let jacobian = IntervalMatrix::from_fn(2 * m, 2 * n, |k, i| match (k < m, i < n) {
            (true, true) => result(m + k * n + i)[0],
            (true, false) => Interval::ZERO,
            (false, true) => rates[k - m][1 + i],
            (false, false) => result(m + (k - m) * n + (i - n))[0],
        });
        Linearized { residuals, jacobian }
    }
}
