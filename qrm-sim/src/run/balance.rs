//! The energy balance of a run: the change of the energy against the work of the loads without potential.

use std::io;

use super::observer::{Observer, Row};

/// An observer that integrates the work of the loads without potential.
#[derive(Clone, Debug, Default)]
pub struct Balance {
    /// The last four rows: time, power, energy.
    window: Vec<(f64, f64, f64)>,
    first: Option<f64>,
    /// Work up to the last row for which it is known.
    pub work: f64,
    /// Change of the energy up to that row.
    pub change: f64,
    /// Largest difference between work and change.
    pub error: f64,
    /// The possible error of the work, where rows are too far apart to show how the power changed between them.
    uncertainty: f64,
    /// Largest difference minus the possible error.
    pub excess: f64,
}

impl Balance {
    /// Adds the work between two rows of the window: the integral of a cubic through all of it.
    fn add(&mut self, from: usize) {
        let window = &self.window;
        let (a, b) = (window[from].0, window[from + 1].0);
        if window.iter().all(|(_, power, _)| *power == 0.0) {
            self.compare(from);
            return;
        }
        let power = |t: f64| {
            let basis = |i: usize| {
                let others = window.iter().enumerate().filter(|(j, _)| *j != i);
                others.map(|(_, other)| (t - other.0) / (window[i].0 - other.0)).product::<f64>()
            };
            (0..window.len()).map(|i| window[i].1 * basis(i)).sum::<f64>()
        };
        // Two Gauss points are exact for a cubic.
        let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
        let offset = half / 3.0_f64.sqrt();
        let work = half * (power(middle - offset) + power(middle + offset));
        self.uncertainty += (work - half * (window[from].1 + window[from + 1].1)).abs();
        self.work += work;
        self.compare(from);
    }

    /// Sets the work up to a row equal to the change of the energy: the power jumped before it.
    pub(crate) fn skip_jump(&mut self, row: &Row) {
        // Two rows do not show how the power changed between them either.
        if self.window.len() > 2 {
            *self = self.finished();
            self.window.drain(..self.window.len() - 1);
        }
        if let Some((_, _, energy)) = self.window.first() {
            self.work += row.energy - energy;
        }
        self.window.clear();
    }

    /// Compares work and change up to the row after `from`.
    fn compare(&mut self, from: usize) {
        self.change = self.window[from + 1].2 - self.first.unwrap_or(0.0);
        let difference = (self.change - self.work).abs();
        self.error = self.error.max(difference);
        self.excess = self.excess.max(difference - self.uncertainty);
    }

    /// The largest difference so far; zero while it is unknown, that is, with fewer than four rows and nonzero power.
    pub(crate) fn largest_known_excess(&self) -> f64 {
        let is_known = self.window.len() == 4 || self.window.iter().all(|(_, power, _)| *power == 0.0);
        if !is_known {
            0.0
        } else if self.window.len() == 4 {
            self.excess
        } else {
            self.finished().excess
        }
    }

    /// The balance after the last row.
    pub(crate) fn finished(&self) -> Self {
        let mut finished = self.clone();
        match finished.window.len() {
            4 => finished.add(2),
            short => (1..short).for_each(|i| finished.add(i - 1)),
        }
        finished
    }
}

impl Observer for Balance {
    fn row(&mut self, row: &Row) -> io::Result<()> {
        self.first.get_or_insert(row.energy);
        // If a run stops just behind a row, rounding errors of both rows would distort a curve through them.
        if let [.., before, last] = &self.window[..]
            && row.t - last.0 < 1e-6 * (last.0 - before.0)
        {
            return Ok(());
        }
        if self.window.len() == 4 {
            self.window.remove(0);
            self.window.push((row.t, row.power, row.energy));
            self.add(1);
        } else {
            self.window.push((row.t, row.power, row.energy));
            if self.window.len() == 4 {
                self.add(0);
                self.add(1);
            }
        }
        Ok(())
    }
    fn finish(&mut self, _last: &[f64]) -> io::Result<()> {
        *self = self.finished();
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(t: f64) -> Row<'static> {
        Row {
            index: 0,
            t,
            q: &[],
            qd: &[],
            qdd: &[],
            multipliers: &[],
            outputs: &[],
            columns: &[],
            residual_position: 0.0,
            residual_velocity: 0.0,
            energy: 5.0 + t.sin(),
            power: t.cos(),
            corrections: 0,
        }
    }

    #[test]
    fn work_is_the_integral_of_power() {
        for count in [2, 3, 4, 5, 100] {
            let mut balance = Balance::default();
            let h = 1.0 / f64::from(count - 1);
            (0..count).for_each(|i| balance.row(&row(f64::from(i) * h)).expect("kept"));
            balance.finish(&[]).expect("finished");
            // A line through two rows, a parabola through three, cubics from then on.
            let order =
                [0.09 * h.powi(2), 0.1 * h.powi(3), 0.1 * h.powi(4)][usize::try_from(count - 2).unwrap_or(2).min(2)];
            assert!((balance.work - 1.0_f64.sin()).abs() < order, "{count}: {}", balance.work);
            assert!((balance.change - 1.0_f64.sin()).abs() < 1e-15 && balance.error < 1.01 * order);
        }
    }
}
