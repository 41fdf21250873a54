//! The solver of the equations of one state.

use qrm_core::Mechanism;

use super::buffers::LoopConstraints;
use super::ldl::Ldl;
use super::rank::constraint_rank;
use super::saddle_point::{SaddlePoint, Undetermined};
use super::singular_position::{INTERPOLATED, PreciseState, SingularPositions};
use super::singularity_distance::{IRREGULAR, SINGULAR, SingularityDistance};
use super::stage_interpolation;
use super::stats::SolverStats;
use crate::state::State;

/// Solves the equations of successive states of a mechanism, without allocations.
#[derive(Clone, Debug)]
pub struct Solver {
    /// Statistics of the solves so far.
    pub stats: SolverStats,
    /// The largest correction of each coordinate so far.
    pub corrections: Vec<f64>,
    pub(super) saddle: SaddlePoint,
    pub(super) constraints: LoopConstraints,
    /// The factors of `Mbar` that define the metric of projections.
    pub(super) metric: Ldl,
    pub(super) has_metric: bool,
    /// Whether the last robust accelerations factored `Mbar`.
    has_mass: bool,
    /// Whether projections do without kernels: these cannot see that a position is singular.
    pub(crate) avoids_kernels: bool,
    pub(super) weights: Vec<f64>,
    pub(super) start: Vec<f64>,
    /// The distance from singular positions, and states near them; created on first use.
    distance: Option<Box<SingularityDistance>>,
    singular_positions: Option<Box<SingularPositions>>,
    /// Solves at neighbours of singular positions; created on first use.
    neighbour_solver: Option<Box<Solver>>,
}

/// The relative error of multipliers that rounding errors cause.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct MultiplierRounding {
    /// The error.
    pub(crate) error: f64,
    /// The error where states are interpolated across a singular position.
    pub(crate) at_pole: Option<f64>,
    /// Whether the position is near a singular one.
    pub(crate) is_irregular: bool,
}

/// The smallest singular value, as a fraction of the largest one, below which multipliers lose digits.
const LOSING: f64 = 0.3;
/// The rounding errors of numbers in a scene, in units of those of the equations (measured with drives of sliders
/// through dead points: 0.2).
const NUMBERS: f64 = 0.125;

impl Solver {
    /// Creates the solver of a mechanism.
    pub fn new(mechanism: &dyn Mechanism) -> Self {
        let description = mechanism.description();
        let (n, m) = (description.coordinates.len(), description.constraints.len());
        Self {
            stats: SolverStats::default(),
            corrections: vec![0.0; n],
            saddle: SaddlePoint::zero(n, m),
            constraints: LoopConstraints::zero(n, m),
            metric: Ldl::with_size(n),
            has_metric: false,
            has_mass: false,
            avoids_kernels: false,
            weights: vec![0.0; m],
            start: vec![0.0; n],
            distance: None,
            singular_positions: None,
            neighbour_solver: None,
        }
    }

    /// Creates the solver of a mechanism at a closed position: if constraints are redundant, multipliers have the least
    /// norm.
    pub fn at(mechanism: &dyn Mechanism, t: f64, q: &[f64]) -> Self {
        Self::with_rank(mechanism, constraint_rank(mechanism, t, q))
    }

    /// Creates the solver of a mechanism with `rank` independent constraints.
    pub fn with_rank(mechanism: &dyn Mechanism, rank: usize) -> Self {
        let mut solver = Self::new(mechanism);
        solver.saddle.rank = rank;
        solver
    }

    /// Whether constraints are redundant along the whole motion; kernels do not support that.
    pub fn is_redundant(&self) -> bool {
        self.saddle.is_redundant()
    }

    /// The number of constraints that are independent at regular positions.
    pub fn rank(&self) -> usize {
        self.saddle.rank
    }

    /// Computes accelerations and multipliers, by the kernel if it is valid at the position.
    ///
    /// # Errors
    /// The accelerations are not determined.
    pub fn accelerations(
        &mut self,
        mechanism: &dyn Mechanism,
        t: f64,
        (q, qd): (&[f64], &[f64]),
        (qdd, multipliers): (&mut [f64], &mut [f64]),
    ) -> Result<(), Undetermined> {
        if !self.is_redundant() && mechanism.accelerations(t, q, qd, qdd, multipliers) {
            return Ok(());
        }
        self.robust_accelerations(mechanism, t, (q, qd), (qdd, multipliers))
    }

    /// Computes accelerations and multipliers by the plain functions; the factors of `Mbar` become the metric of the
    /// next projection.
    ///
    /// If constraints become dependent, or one of them vanishes, at a single position only, they are insufficient there
    /// and very close to it. The accelerations are then interpolated along the motion, from states shortly before and
    /// after.
    ///
    /// # Errors
    /// The accelerations are not determined.
    pub fn robust_accelerations(
        &mut self,
        mechanism: &dyn Mechanism,
        t: f64,
        (q, qd): (&[f64], &[f64]),
        (qdd, multipliers): (&mut [f64], &mut [f64]),
    ) -> Result<(), Undetermined> {
        let before = self.stats.suspicious_constraints;
        self.saddle.dynamics.evaluate(mechanism, t, q, qd);
        self.has_mass = self.saddle.solve(qdd, multipliers, &mut self.stats)?;
        let is_suspicious = self.stats.suspicious_constraints != before;
        let jacobian = &self.saddle.dynamics.constraint_jacobian;
        let distance = distance(&mut self.distance, mechanism, self.saddle.rank, t, (q, qd));
        let fraction = distance.and_then(|distance| {
            let value = distance.find(jacobian)?;
            distance.fraction(value, IRREGULAR)
        });
        if is_suspicious || fraction.is_some_and(|fraction| fraction < SINGULAR) {
            // Rounding errors of the equations alone, at the given state, grow with the square of the distance.
            let own_error = fraction.map_or(f64::INFINITY, |fraction| f64::EPSILON / fraction.powi(2));
            let rank = self.saddle.rank;
            let solver = self.neighbour_solver.get_or_insert_with(|| Box::new(Self::with_rank(mechanism, rank)));
            stage_interpolation::interpolate(mechanism, solver, t, (q, qd), own_error, (qdd, multipliers));
        }
        Ok(())
    }

    /// The smallest singular value of `C_q` as a fraction of that at regular positions, if it is below `limit`.
    pub(crate) fn singularity_fraction(
        &mut self,
        mechanism: &dyn Mechanism,
        limit: f64,
        t: f64,
        (q, qd): (&[f64], &[f64]),
    ) -> Option<f64> {
        if self.weights.is_empty() {
            return None;
        }
        self.constraints.evaluate(mechanism, t, q);
        let jacobian = &self.constraints.constraint_jacobian;
        let distance = distance(&mut self.distance, mechanism, self.saddle.rank, t, (q, qd))?;
        distance.find(jacobian).and_then(|value| distance.fraction(value, limit))
    }

    /// The state at coordinates and rates, in all digits, where the smallest singular value of `C_q` is below `limit`
    /// of that at regular positions; `None` elsewhere, and where it is not determined.
    pub(crate) fn precise_state(
        &mut self,
        mechanism: &dyn Mechanism,
        limit: f64,
        t: f64,
        (q, qd): (&[f64], &[f64]),
    ) -> Option<PreciseState> {
        let fraction = self.singularity_fraction(mechanism, limit, t, (q, qd))?;
        let state = self.singular_positions(mechanism, t, q)?.state(mechanism, fraction, t, (q, qd))?;
        if state.has_pole {
            self.stats.unbounded_at.get_or_insert(t);
        }
        Some(state)
    }

    /// The relative error of multipliers at a position that rounding errors cause, where they lose digits: it grows with
    /// the fourth power of the distance from a singular position. Nearer than [`IRREGULAR`] the equations are solved in
    /// all digits, but for rounding errors of the scene's numbers.
    pub(crate) fn rounding_of_multipliers(&mut self, mechanism: &dyn Mechanism, state: &State) -> MultiplierRounding {
        let State { t, q, qd, .. } = state;
        self.constraints.evaluate(mechanism, *t, q);
        let jacobian = &self.constraints.constraint_jacobian;
        let distance = distance(&mut self.distance, mechanism, self.saddle.rank, *t, (q, qd));
        let fraction = distance.map_or(1.0, |distance| distance.fraction_at(jacobian));
        let [of_equations, of_numbers] = [1.0, NUMBERS].map(|part| part * f64::EPSILON / fraction.powi(4));
        let (error, at_pole) = match fraction {
            fraction if fraction < INTERPOLATED => {
                let positions = self.singular_positions(mechanism, *t, q);
                let error = positions.and_then(|positions| positions.rounding(mechanism, fraction, *t, (q, qd)));
                let error = error.unwrap_or(0.0);
                (error, Some(error))
            }
            fraction if fraction < IRREGULAR => (of_numbers, None),
            fraction if fraction < LOSING => (of_equations, None),
            _ => (0.0, None),
        };
        MultiplierRounding { error, at_pole, is_irregular: fraction < IRREGULAR }
    }

    /// Whether a completed state came so near a singular position that rounding errors of forces are irregular.
    pub(crate) fn is_irregular(&self) -> bool {
        self.distance.as_ref().is_some_and(|distance| distance.is_irregular())
    }

    /// The solver of states near singular positions; `None` if the mechanism has no tape.
    fn singular_positions(&mut self, mechanism: &dyn Mechanism, t: f64, q: &[f64]) -> Option<&mut SingularPositions> {
        if self.singular_positions.is_none() {
            self.singular_positions = SingularPositions::new(mechanism, self.saddle.rank, t, q).map(Box::new);
        }
        self.singular_positions.as_deref_mut()
    }

    /// Factors `Mbar` at a position, as the metric of the next projection.
    pub fn factor_mass(&mut self, mechanism: &dyn Mechanism, q: &[f64]) {
        mechanism.mass_matrix(q, self.saddle.dynamics.mass_matrix.entries_mut());
        self.has_metric = self.metric.factor(&self.saddle.dynamics.mass_matrix);
    }

    /// Whether `Mbar` is regular at the position of the last projection, or of the last
    /// [`factor_mass`](Self::factor_mass).
    pub(crate) fn has_metric(&self) -> bool {
        self.has_metric
    }

    /// Uses the factors of `Mbar` of the last robust accelerations as the metric of the next projection.
    pub fn take_metric(&mut self) {
        self.has_metric = self.has_mass;
        std::mem::swap(&mut self.metric, &mut self.saddle.mass);
    }
}

/// The distance from singular positions, which begins at a closed position; `None` without constraints or a tape.
fn distance<'a>(
    known: &'a mut Option<Box<SingularityDistance>>,
    mechanism: &dyn Mechanism,
    rank: usize,
    t: f64,
    motion: (&[f64], &[f64]),
) -> Option<&'a mut SingularityDistance> {
    if mechanism.description().constraints.is_empty() || mechanism.tape().is_none() {
        return None;
    }
    Some(known.get_or_insert_with(|| Box::new(SingularityDistance::at(mechanism, rank, t, motion))))
}
