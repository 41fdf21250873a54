//! Bounds of the steps that a method chooses, for changes that a tolerance alone would miss.

/// The largest number of times at which steps are forced to end.
const MOST: usize = 64;

/// The longest step, and times at which a step ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StepBounds {
    /// The longest step, in s.
    pub longest: f64,
    /// Increasing times, padded with infinity.
    ends: [f64; MOST],
}

impl Default for StepBounds {
    fn default() -> Self {
        Self { longest: f64::INFINITY, ends: [f64::INFINITY; MOST] }
    }
}

impl StepBounds {
    /// Creates bounds from a longest step and times. Steps end at the first 64 times; if there are more, all steps are
    /// at most as long as the shortest interval between the remaining ones.
    pub fn new(longest: f64, times: &[f64]) -> Self {
        let mut times: Vec<f64> = times.iter().copied().filter(|time| time.is_finite()).collect();
        times.sort_unstable_by(f64::total_cmp);
        times.dedup();
        let intervals = times.get(MOST - 1..).unwrap_or_default().windows(2).map(|pair| pair[1] - pair[0]);
        let mut bounds = Self { longest: intervals.fold(longest, f64::min), ..Self::default() };
        bounds.ends.iter_mut().zip(times).for_each(|(end, time)| *end = time);
        bounds
    }

    /// The first time after `t` at which a step ends.
    pub(crate) fn next_end(&self, t: f64) -> f64 {
        // Rounding errors may leave a step just before its end.
        let after = t + 1e-12 * t.abs();
        self.ends.iter().copied().find(|end| *end > after).unwrap_or(f64::INFINITY)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ends_come_in_their_order() {
        let bounds = StepBounds::new(0.1, &[3.0, f64::NAN, 1.0, f64::INFINITY]);
        assert_eq!([0.0, 1.0, 2.5, 3.0].map(|t| bounds.next_end(t)), [1.0, 3.0, 3.0, f64::INFINITY]);
    }

    #[test]
    fn too_many_ends_shorten_every_step() {
        let times: Vec<f64> = (1..=MOST).map(|i| i as f64).collect();
        assert_eq!(StepBounds::new(10.0, &times).longest, 10.0);
        let more: Vec<f64> = times.iter().copied().chain([MOST as f64 + 0.25, MOST as f64]).collect();
        assert_eq!(StepBounds::new(10.0, &more).longest, 0.25);
    }
}
