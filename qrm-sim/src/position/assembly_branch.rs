//! The start of a mechanism with changed parameters or given values, on the branch of its scene's own start.

use qrm_core::{Mechanism, TapeEvaluator};

use super::assembly::{NotAssembled, assemble_from_guesses, completed};
use super::loop_solver::{CoordinatePartition, LoopSolver, Position};
use super::start::Start;
use super::start_uncertainty::start_uncertainty;

/// The largest difference of an angle from the scene's own start for which the branch is the same without further test.
const NEAR: f64 = 0.5;
/// The longest change of an angle in a step of the parameters.
const LONGEST: f64 = 0.2;
/// The smallest fraction of the path that is tried as a step.
const SHORTEST: f64 = 1e-6;

/// The assembly branch of a mechanism, defined by the scene's own parameters.
///
/// With changed parameters, the first guesses of a scene may lead to a mirrored position, or to none. In that case
/// parameters and given values change gradually from the scene's own, and the position follows continuously.
#[derive(Clone, Debug)]
pub(crate) struct AssemblyBranch {
    /// The scene's own start; `None` if the given coordinates do not determine the others, and for mechanisms that are
    /// not generated.
    own: Option<SceneStart>,
}

#[derive(Clone, Debug)]
struct SceneStart {
    parameters: Vec<f64>,
    start: Start,
    position: Position,
    partition: CoordinatePartition,
}

impl SceneStart {
    fn new(mechanism: &dyn Mechanism, parameters: Option<Vec<f64>>) -> Option<Self> {
        let of_scene = |tape| TapeEvaluator::<Vec<f64>>::new(tape).parameters().to_vec();
        let parameters = parameters.or_else(|| mechanism.tape().map(of_scene))?;
        let own = mechanism.with_parameters(parameters.clone())?;
        let start = Start::new(&*own);
        let drive = LoopSolver::new(&*own, start.given.clone())?;
        let position = drive.solve_loops(assemble_from_guesses(&*own, &start).ok()?.0)?;
        let partition = drive.into_partition();
        // At a dead point two branches meet.
        let has_branch = position.determinant != 0.0 && !is_at_dead_point(&*own, &start, &position.q);
        has_branch.then_some(Self { parameters, start, position, partition })
    }
}

impl AssemblyBranch {
    /// Creates the branch of a mechanism's scene.
    pub(crate) fn new(mechanism: &dyn Mechanism) -> Self {
        Self::with_parameters(mechanism, None)
    }

    /// Creates the branch of a mechanism's scene with these values of the scene's own parameters; those of the model if
    /// `None`.
    pub(crate) fn with_parameters(mechanism: &dyn Mechanism, parameters: Option<Vec<f64>>) -> Self {
        Self { own: SceneStart::new(mechanism, parameters) }
    }

    /// Computes coordinates and rates of a mechanism of this scene at a start.
    ///
    /// # Errors
    /// Some constraint cannot be satisfied, or only on another branch.
    pub(crate) fn assemble(
        &self,
        mechanism: &dyn Mechanism,
        mut start: Start,
    ) -> Result<(Vec<f64>, Vec<f64>), NotAssembled> {
        // Other guesses ask for another branch.
        let has_guesses_of =
            |own: &SceneStart| (0..start.q.len()).all(|i| start.given[i] || start.q[i] == own.start.q[i]);
        let is_own = |own: &SceneStart| mechanism.parameters() == own.parameters && start.q == own.start.q;
        let is_other = |own: &&SceneStart| !is_own(own) && has_guesses_of(own);
        let Some(own) = self.own.as_ref().filter(is_other) else { return assemble_from_guesses(mechanism, &start) };
        let drive = own.drive(mechanism);
        if let Some(position) = own.neighbour(&drive, &start, &own.position)
            && let Some(found) = completed(&drive, &start, position)
        {
            return Ok(found);
        }
        let direct = assemble_from_guesses(mechanism, &start);
        if let Ok((q, _)) = &direct
            && let Some(position) = drive.solve_loops(q.clone())
            && position.determinant * own.position.determinant > 0.0
            && own.max_angle_change(mechanism, &own.position, &position.q) < NEAR
        {
            return direct;
        }
        match (own.follow(mechanism, &start), direct) {
            (Ok(position), _) => {
                start.q = position.q;
                assemble_from_guesses(mechanism, &start)
            }
            (Err(_), Err(reason)) => Err(reason),
            (Err(last), Ok((q, qd))) => {
                // The branches meet there.
                if is_at_dead_point(mechanism, &start, &q) && own.max_angle_change(mechanism, &last, &q) < LONGEST {
                    return Ok((q, qd));
                }
                Err(NotAssembled { constraint: 0, residual: 0.0, q, rates: false, is_other_branch: true })
            }
        }
    }
}

impl SceneStart {
    /// Follows the position from the scene's own parameters and given values to those of a mechanism and a start.
    ///
    /// # Errors
    /// The last position before a singular one on the way.
    fn follow(&self, mechanism: &dyn Mechanism, start: &Start) -> Result<Position, Position> {
        let (mut now, mut done, mut step) = (self.position.clone(), 0.0, 0.125_f64);
        while done < 1.0 {
            let next = (done + step).min(1.0);
            let value = |(own, to): (&f64, &f64)| if next == 1.0 { *to } else { own + (to - own) * next };
            let values = self.parameters.iter().zip(mechanism.parameters()).map(value).collect();
            let Some(between) = mechanism.with_parameters(values) else { return Err(now) };
            let start = Start { q: self.start.q.iter().zip(&start.q).map(value).collect(), ..start.clone() };
            match self.neighbour(&self.drive(&*between), &start, &now) {
                Some(position) => {
                    (now, done) = (position, next);
                    step *= 2.0;
                }
                None if step <= SHORTEST => return Err(now),
                None => step *= 0.5,
            }
        }
        Ok(now)
    }

    /// The position after a small change of the parameters to those of another mechanism.
    fn neighbour(&self, drive: &LoopSolver, start: &Start, from: &Position) -> Option<Position> {
        let guess = (0..from.q.len()).map(|i| if start.given[i] { start.q[i] } else { from.q[i] }).collect();
        let position = drive.solve_loops(guess)?;
        (position.is_on_branch_of(from) && self.max_angle_change(drive.mechanism, from, &position.q) < LONGEST)
            .then_some(position)
    }

    fn drive<'m>(&'m self, mechanism: &'m dyn Mechanism) -> LoopSolver<'m> {
        LoopSolver::with_partition(mechanism, &self.partition)
    }

    /// The largest change of an angle that is not given.
    fn max_angle_change(&self, mechanism: &dyn Mechanism, from: &Position, to: &[f64]) -> f64 {
        let is_free_angle = |i: &usize| !self.start.given[*i] && mechanism.description().is_angle(*i);
        (0..to.len()).filter(is_free_angle).map(|i| (to[i] - from.q[i]).abs()).fold(0.0, f64::max)
    }
}

/// Whether the given coordinates of a start are at a dead point at the coordinates `q`.
fn is_at_dead_point(mechanism: &dyn Mechanism, start: &Start, q: &[f64]) -> bool {
    // A page has no room for it.
    cfg!(feature = "events")
        && start_uncertainty(mechanism, start, q).is_some_and(|uncertainty| uncertainty.is_at_dead_point())
}

/// Computes coordinates and rates of a mechanism at a start, on the branch of its scene's own parameters.
///
/// # Errors
/// Some constraint cannot be satisfied, or only on another branch.
pub fn assemble(mechanism: &dyn Mechanism, start: Start) -> Result<(Vec<f64>, Vec<f64>), NotAssembled> {
    AssemblyBranch::new(mechanism).assemble(mechanism, start)
}
