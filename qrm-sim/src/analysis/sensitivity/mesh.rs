//! The steps of a run, to be made again on dual numbers.

use std::collections::VecDeque;

use qrm_core::Mechanism;

use crate::integrate::{Formula, Integrator, MethodSettings, StepError};
use crate::state::State;

/// The steps of an ordinary run from row to row. They end at rows too.
pub(super) struct Mesh<'m> {
    mechanism: &'m dyn Mechanism,
    /// The run, and its last two rows; `None` where rows are its steps.
    run: Option<(Integrator, [State; 2])>,
    /// The steps that end behind the last row.
    ahead: VecDeque<(f64, Formula)>,
    /// The time of the last row.
    t: f64,
    /// Whether steps and rows are half as long.
    is_halved: bool,
}

/// A step to make.
#[derive(Clone, Copy, Debug)]
pub(super) struct MeshStep {
    pub(super) end: f64,
    pub(super) formula: Formula,
    /// Whether it ends at a row.
    pub(super) is_row: bool,
}

impl<'m> Mesh<'m> {
    /// Begins at a state.
    ///
    /// # Errors
    /// The method does not suit the scene, or the accelerations near the start are not determined.
    pub(super) fn new(
        mechanism: &'m dyn Mechanism,
        settings: MethodSettings,
        first: &State,
        end_time: f64,
        is_halved: bool,
    ) -> Result<Self, StepError> {
        let run = if settings.method.is_adaptive() {
            let integrator = Integrator::new(mechanism, settings, first, end_time)?;
            Some((integrator, [first.clone(), first.clone()]))
        } else {
            None
        };
        Ok(Self { mechanism, run, ahead: VecDeque::new(), t: first.t, is_halved })
    }

    /// The steps to the next row, at `t`.
    ///
    /// # Errors
    /// The run does not get there.
    pub(super) fn steps_to(&mut self, t: f64) -> Result<Vec<MeshStep>, StepError> {
        if let Some((integrator, [from, to])) = &mut self.run {
            integrator.advance(self.mechanism, from, t, to)?;
            std::mem::swap(from, to);
            self.ahead.extend(integrator.take_steps());
        }
        let mut steps = Vec::new();
        while let Some((end, formula)) = self.ahead.pop_front_if(|(end, _)| *end < t) {
            steps.push(MeshStep { end, formula, is_row: false });
        }
        let formula = self.ahead.front().map_or(Formula::fixed(), |(_, formula)| *formula);
        steps.push(MeshStep { end: t, formula, is_row: true });
        self.ahead.pop_front_if(|(end, _)| *end == t);
        let begin = std::mem::replace(&mut self.t, t);
        Ok(if self.is_halved { halved(begin, &steps) } else { steps })
    }
}

/// Steps half as long, with a row in the middle.
fn halved(begin: f64, steps: &[MeshStep]) -> Vec<MeshStep> {
    let row = middle(begin, steps.last().map_or(begin, |last| last.end));
    let mut from = begin;
    let mut halved = Vec::with_capacity(2 * steps.len() + 1);
    for step in steps {
        let half = middle(from, step.end);
        let inner = if row < half { [row, half] } else { [half, row] };
        let inner = inner.into_iter().filter(|end| from < *end && *end < step.end);
        halved.extend(inner.map(|end| MeshStep { end, is_row: end == row, ..*step }));
        halved.push(MeshStep { is_row: step.is_row || step.end == row, ..*step });
        from = step.end;
    }
    halved.dedup_by(|b, a| b.end == a.end);
    halved
}

fn middle(a: f64, b: f64) -> f64 {
    0.5 * (a + b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_step_is_halved_and_the_row_too() {
        let step = |end: f64, is_row| MeshStep { end, formula: Formula::fixed(), is_row };
        let ends = |steps: &[MeshStep]| steps.iter().map(|step| (step.end, step.is_row)).collect::<Vec<_>>();
        assert_eq!(ends(&halved(1.0, &[step(3.0, true)])), [(2.0, true), (3.0, true)]);
        let two = halved(0.0, &[step(6.0, false), step(8.0, true)]);
        assert_eq!(ends(&two), [(3.0, false), (4.0, true), (6.0, false), (7.0, false), (8.0, true)]);
    }
}
