//! The rows of a run, and their receivers.

use super::extremes::Extremes;

/// A row of a trajectory.
#[derive(Clone, Copy, Debug)]
pub struct Row<'a> {
    /// The number of the row in the trajectory.
    pub index: u64,
    /// Time.
    pub t: f64,
    /// Coordinates.
    pub q: &'a [f64],
    /// Rates.
    pub qd: &'a [f64],
    /// Accelerations.
    pub qdd: &'a [f64],
    /// Multipliers.
    pub multipliers: &'a [f64],
    /// Outputs.
    pub outputs: &'a [f64],
    /// All numbers of the row, in the order of [`columns`](crate::columns::columns): tables copy them as they are.
    pub columns: &'a [f64],
    /// Largest residual of the constraints.
    pub residual_position: f64,
    /// Largest rate of a residual.
    pub residual_velocity: f64,
    /// Kinetic energy and potential of the conservative loads, in J.
    pub energy: f64,
    /// Power of the loads that have no potential, in W.
    pub power: f64,
    /// The number of corrections of the coordinates in the step that ends here.
    pub corrections: u32,
}

/// A receiver of rows; `()` ignores them, a pair passes them to both.
pub trait Observer {
    /// Receives a row.
    ///
    /// # Errors
    /// The row cannot be kept; the run ends.
    fn row(&mut self, row: &Row) -> std::io::Result<()>;

    /// Whether rows must have outputs; without them no output can be undefined.
    fn needs_outputs(&self) -> bool {
        true
    }

    /// Whether extremes are needed: only then [`extremes`](Self::extremes) is called.
    fn wants_extremes(&self) -> bool {
        false
    }

    /// Receives the extremes of all columns except checks, in their order, including those between rows; called once
    /// after the last row.
    fn extremes(&mut self, _extremes: &[Extremes]) {}

    /// Called between blocks of rows; `false` ends the run.
    ///
    /// # Errors
    /// The rows so far cannot be kept; the run ends.
    fn keep_running(&mut self, _t: f64, _end_time: f64) -> std::io::Result<bool> {
        Ok(true)
    }

    /// Called once after the last row, with its columns; they are empty if there was no row, or it could not be kept.
    ///
    /// # Errors
    /// The rows so far cannot be kept.
    fn finish(&mut self, _last: &[f64]) -> std::io::Result<()> {
        Ok(())
    }
}

impl Observer for () {
    fn row(&mut self, _row: &Row) -> std::io::Result<()> {
        Ok(())
    }
}

impl<A: Observer, B: Observer> Observer for (A, B) {
    fn row(&mut self, row: &Row) -> std::io::Result<()> {
        self.0.row(row)?;
        self.1.row(row)
    }

    fn needs_outputs(&self) -> bool {
        self.0.needs_outputs() || self.1.needs_outputs()
    }

    fn wants_extremes(&self) -> bool {
        self.0.wants_extremes() || self.1.wants_extremes()
    }

    fn extremes(&mut self, extremes: &[Extremes]) {
        self.0.extremes(extremes);
        self.1.extremes(extremes);
    }

    fn keep_running(&mut self, t: f64, end_time: f64) -> std::io::Result<bool> {
        Ok(self.0.keep_running(t, end_time)? && self.1.keep_running(t, end_time)?)
    }

    fn finish(&mut self, last: &[f64]) -> std::io::Result<()> {
        let first = self.0.finish(last);
        self.1.finish(last).and(first)
    }
}

#[cfg(test)]
mod tests {
    use std::io::{Error, Result};

    use super::*;

    /// Counts calls of `finish`, and fails in some of them; wants outputs unless it fails.
    struct Ends(usize, bool);

    impl Observer for Ends {
        fn row(&mut self, _: &Row) -> Result<()> {
            Ok(())
        }

        fn needs_outputs(&self) -> bool {
            !self.1
        }

        fn finish(&mut self, _: &[f64]) -> Result<()> {
            self.0 += 1;
            if self.1 { Err(Error::other("full")) } else { Ok(()) }
        }
    }

    #[test]
    fn both_of_a_pair_are_asked() {
        for (fails, others) in [(false, false), (true, false), (false, true), (true, true)] {
            let mut pair = (Ends(0, fails), Ends(0, others));
            assert_eq!(pair.needs_outputs(), !fails || !others);
            assert_eq!(pair.finish(&[]).is_err(), fails || others);
            assert_eq!((pair.0.0, pair.1.0), (1, 1));
        }
    }
}
