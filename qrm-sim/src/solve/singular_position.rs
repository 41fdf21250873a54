//! States at and near singular positions, where sixteen digits do not suffice.
//!
//! At a distance `d` from such a position, a rounding error of a closure is magnified by `1/d` in the coordinates, by
//! `1/d^2` in the rates, by `1/d^3` in the accelerations and by `1/d^4` in the multipliers. The motion through an
//! isolated singular position is smooth all the same: near it the equations are solved in double-double precision, and
//! at it the state is that of the polynomial through such states on both sides.

use qrm_core::{Mechanism, Scalar};

use super::buffers::LoopConstraints;
use super::ldl::PivotedLdl;
use super::matrix::largest;
use super::precise::{Number, PreciseEquations};
use super::rank::row_products;

/// The smallest singular value, as a fraction of the largest one, from which the equations determine the state.
pub(crate) const INTERPOLATED: f64 = 4e-3;
/// The smallest singular value, as a fraction of the largest one, below which a pole of the multipliers is reached, and
/// the growth of the multipliers over the distance `DISTANCES[0]`.
const AT_POLE: f64 = 1e-5;
const POLE_GROWTH: f64 = 10.0;
/// Distances of the interpolation points, in rad or m.
const DISTANCES: [f64; 3] = [1e-3, 1e-2, 1e-4];
/// The smallest distance of interpolation points, in fractions of the smallest singular value.
const BOTH_SIDES: f64 = 3.0;
/// The largest estimated errors of coordinates, rates, accelerations and multipliers in a precise interpolation.
const PRECISE: [f64; 4] = [1e-15, 1e-15, 1e-15, 1e-12];
/// The estimated error of the accelerations from which no other distance is tried.
const HOPELESS: f64 = 1e-2;
/// The largest estimated error of coordinates, rates and accelerations that are interpolated, relative to their largest
/// value.
const SMOOTH_STATE: f64 = 1e-9;
/// The largest estimated error of multipliers that are interpolated, relative to the largest one: rounding errors of
/// the scene's numbers are `1e-17/d^4` of them at a distance `d`, and at a pole none of their digits is right.
const SMOOTH_MULTIPLIERS: f64 = 1e-6;
/// The weights of positions at one to four distances on each side, in the polynomial of degree 7 through all of them.
const WEIGHTS: [f64; 4] = [4.0 / 5.0, -2.0 / 5.0, 4.0 / 35.0, -1.0 / 70.0];
/// The weights of the same positions in the polynomial of degree 5 through the inner six: the difference between the
/// two polynomials is the estimated error.
const INNER_WEIGHTS: [f64; 4] = [3.0 / 4.0, -3.0 / 10.0, 1.0 / 20.0, 0.0];
/// The largest change of a coordinate by corrections near a singular position, in parts of the distance from it.
const MOST_MOVED: f64 = 0.1;
/// The largest number of corrections of a position.
const CORRECTIONS: usize = 6;
/// The size of corrections that end them, relative to the largest coordinate, near singular positions and in a
/// polynomial across one: corrections square errors.
const CONVERGED: [f64; 2] = [1e-13, 1e-16];

/// A state in double-double precision, rounded.
#[derive(Clone, Debug)]
pub(crate) struct PreciseState {
    n: usize,
    /// Coordinates, rates, accelerations, multipliers.
    values: Vec<f64>,
    /// The estimated errors of these four, each relative to its largest value, coordinates at least to the distance of
    /// the interpolation points and accelerations at least to the square of the rates.
    errors: [f64; 4],
    /// Whether the multipliers grow without bound at the position.
    pub(crate) has_pole: bool,
}

impl PreciseState {
    /// Whether no other interpolation would be better.
    fn is_precise(&self) -> bool {
        self.errors.iter().zip(PRECISE).all(|(error, precise)| *error <= precise)
    }

    /// Takes the motion of another interpolation, if its accelerations are better, and its multipliers likewise.
    fn take_better(&mut self, other: &Self) {
        let end_of_motion = 3 * self.n;
        if other.errors[2] < self.errors[2] {
            self.errors[..3].copy_from_slice(&other.errors[..3]);
            self.values[..end_of_motion].copy_from_slice(&other.values[..end_of_motion]);
        }
        if other.errors[3] < self.errors[3] {
            self.errors[3] = other.errors[3];
            self.values[end_of_motion..].copy_from_slice(&other.values[end_of_motion..]);
        }
    }

    /// Writes the coordinates and rates on the constraints.
    pub(crate) fn write_motion(&self, q: &mut [f64], qd: &mut [f64]) {
        q.copy_from_slice(&self.values[..self.n]);
        qd.copy_from_slice(&self.values[self.n..2 * self.n]);
    }

    /// Writes the state into a row: see [`RowLayout`](qrm_core::RowLayout).
    pub(crate) fn write(&self, row: &mut [f64]) {
        row[1..=self.values.len()].copy_from_slice(&self.values);
    }

    /// Writes the accelerations and multipliers.
    pub(crate) fn write_dynamics(&self, qdd: &mut [f64], multipliers: &mut [f64]) {
        qdd.copy_from_slice(&self.values[2 * self.n..3 * self.n]);
        multipliers.copy_from_slice(&self.values[3 * self.n..]);
    }
}

/// Solves for states at and near singular positions.
#[derive(Clone, Debug)]
pub(crate) struct SingularPositions {
    equations: PreciseEquations<'static>,
}

impl SingularPositions {
    /// Begins with a mechanism of `rank` independent constraints near a position; `None` if it has no tape.
    pub(crate) fn new(mechanism: &dyn Mechanism, rank: usize, t: f64, q: &[f64]) -> Option<Self> {
        let jacobian = LoopConstraints::at(mechanism, t, q).constraint_jacobian;
        let independent = if rank == jacobian.rows() {
            (0..rank).collect()
        } else {
            PivotedLdl::with_rank(&row_products(&jacobian), rank).independent().to_vec()
        };
        Some(Self { equations: PreciseEquations::new(mechanism.tape()?, mechanism.parameters(), independent) })
    }

    /// The state at a position whose smallest singular value is this fraction of the largest one; `None` if the
    /// equations do not determine it.
    pub(crate) fn state(
        &mut self,
        mechanism: &dyn Mechanism,
        fraction: f64,
        t: f64,
        (q, qd): (&[f64], &[f64]),
    ) -> Option<PreciseState> {
        if fraction > INTERPOLATED
            && let Some(near) = self.near(mechanism, t, (q, qd), MOST_MOVED * fraction)
        {
            return Some(near);
        }
        let across = self.across(mechanism, fraction, t, (q, qd))?;
        if !across.errors[..3].iter().all(|error| *error <= SMOOTH_STATE) {
            return None;
        }
        if across.errors[3] <= SMOOTH_MULTIPLIERS {
            return Some(across);
        }
        // The multipliers jump or have a pole here. The equations determine them as long as the position is not exactly
        // singular.
        let (q, qd) = across.values[..2 * across.n].split_at(across.n);
        let here = self.near(mechanism, t, (q, qd), MOST_MOVED * fraction)?;
        // Rows hardly come so near: the search for extremes does.
        let has_pole = cfg!(feature = "extremes") && fraction < AT_POLE && {
            let later = self.later(mechanism, t, (q, qd), DISTANCES[0] / largest(qd).1)?;
            let size = later[3 * across.n..].iter().map(|x| x.to_f64().abs()).fold(0.0, f64::max);
            largest(&here.values[3 * across.n..]).1 > POLE_GROWTH * size
        };
        Some(PreciseState { has_pole, ..here })
    }

    /// The state near a position, on the constraints; `None` if the equations do not determine it.
    fn near(
        &mut self,
        mechanism: &dyn Mechanism,
        t: f64,
        (q, qd): (&[f64], &[f64]),
        most_moved: f64,
    ) -> Option<PreciseState> {
        self.set_parameters(mechanism);
        let y = q.iter().chain(qd).map(|x| Number::from(*x)).collect();
        let values = self.solved(t.into(), y, CONVERGED[0])?;
        // Corrections that are not small may lead to another position.
        let moved = values.iter().zip(q).map(|(to, from)| (to.to_f64() - from).abs()).fold(0.0, f64::max);
        (moved <= most_moved).then_some(())?;
        let values = values.into_iter().map(Scalar::to_f64).collect();
        Some(PreciseState { n: q.len(), values, errors: [0.0; 4], has_pole: false })
    }

    /// The state at a singular position, interpolated along the rates over the distances with the least errors; `None`
    /// at rest, and where the equations do not determine states on both sides.
    fn across(
        &mut self,
        mechanism: &dyn Mechanism,
        fraction: f64,
        t: f64,
        (q, qd): (&[f64], &[f64]),
    ) -> Option<PreciseState> {
        self.set_parameters(mechanism);
        let speed = largest(qd).1;
        if !(speed > 0.0 && speed.is_finite()) {
            return None;
        }
        let mut best: Option<PreciseState> = None;
        // Points on one side of the position would all share its rounding errors.
        let is_on_both_sides = |distance: &f64| *distance > BOTH_SIDES * fraction || *distance == DISTANCES[1];
        for distance in DISTANCES.into_iter().filter(is_on_both_sides) {
            let found = self.interpolated(mechanism, t, (q, qd), distance / speed);
            // Where nothing is smooth, other distances would not help.
            let Some(found) = found.filter(|found| best.is_some() || found.errors[2] <= HOPELESS) else { break };
            match &mut best {
                Some(best) => best.take_better(&found),
                None => best = Some(found),
            }
            if best.as_ref().is_some_and(PreciseState::is_precise) {
                break;
            }
        }
        best
    }

    /// The error of the multipliers at a singular position, relative to the largest one, that rounding errors of the
    /// numbers in the scene cause: the largest difference between polynomials through states at various distances.
    /// `None` if they are not determined.
    pub(crate) fn rounding(
        &mut self,
        mechanism: &dyn Mechanism,
        fraction: f64,
        t: f64,
        (q, qd): (&[f64], &[f64]),
    ) -> Option<f64> {
        let own = self.across(mechanism, fraction, t, (q, qd))?;
        let speed = largest(qd).1;
        let size = largest(&own.values[3 * own.n..]).1;
        let mut rounding = own.errors[3] * size;
        for distance in [DISTANCES[1], 2.0 * DISTANCES[1]] {
            let other = self.interpolated(mechanism, t, (q, qd), distance / speed)?;
            let multipliers = own.values.iter().zip(&other.values).skip(3 * own.n);
            rounding = multipliers.fold(rounding, |rounding, (own, other)| rounding.max((own - other).abs()));
        }
        (size > 0.0).then(|| rounding / size)
    }

    fn set_parameters(&mut self, mechanism: &dyn Mechanism) {
        let parameters = mechanism.parameters();
        self.equations.evaluator.set_parameters(|i| Some(parameters[i].into()));
    }

    /// The polynomial at a state through those at multiples of `duration` along its rates.
    fn interpolated(
        &mut self,
        mechanism: &dyn Mechanism,
        t: f64,
        (q, qd): (&[f64], &[f64]),
        duration: f64,
    ) -> Option<PreciseState> {
        let (values, differences) = interpolated(|place| self.later(mechanism, t, (q, qd), place * duration))?;
        let n = q.len();
        let speed = largest(qd).1;
        let parts = [0..n, n..2 * n, 2 * n..3 * n, 3 * n..values.len()];
        // Coordinates may be zero at the position, and accelerations all the time.
        let smallest = [duration * speed, 0.0, speed * speed, 0.0];
        let errors = [0, 1, 2, 3].map(|k| {
            let size = largest(&values[parts[k].clone()]).1.max(smallest[k]);
            if size > 0.0 { largest(&differences[parts[k].clone()]).1 / size } else { 0.0 }
        });
        Some(PreciseState { n, values, errors, has_pole: false })
    }

    /// The values of a state on the constraints after a time along the rates, which may be negative.
    fn later(
        &mut self,
        mechanism: &dyn Mechanism,
        t: f64,
        (q, qd): (&[f64], &[f64]),
        duration: f64,
    ) -> Option<Vec<Number>> {
        let later = Number::from(duration);
        // Constraints that depend on time are evaluated at the time at which the motion is there.
        let at = if mechanism.is_driven() { Number::from(t) + later } else { t.into() };
        let moved = q.iter().zip(qd).map(|(q, qd)| Number::from(*q) + later * Number::from(*qd));
        self.solved(at, moved.chain(qd.iter().map(|x| Number::from(*x))).collect(), CONVERGED[1])
    }

    /// The coordinates, rates, accelerations and multipliers on the constraints near coordinates and rates.
    fn solved(&mut self, t: Number, mut y: Vec<Number>, converged: f64) -> Option<Vec<Number>> {
        let n = y.len() / 2;
        let size = y[..n].iter().fold(1.0, |size: f64, x| size.max(x.to_f64().abs()));
        self.equations.set_metric(&y[..n]);
        for _ in 0..CORRECTIONS {
            if self.equations.correct_coordinates(t, &mut y[..n])? <= converged * size {
                // The factors are those of the last position but one: a second correction removes their error.
                for _ in 0..CORRECTIONS {
                    if self.equations.correct_rates(t, &mut y)? <= converged * size {
                        break;
                    }
                }
                let accelerations = self.equations.accelerations(t, &y)?[..n].to_vec();
                let multipliers = self.equations.multipliers()?;
                y.extend(accelerations);
                y.extend(multipliers);
                return Some(y);
            }
        }
        None
    }
}

/// The polynomial of degree 7 through values at four places on each side of zero, and its difference from the one
/// through the inner six; `None` if a value is not determined.
pub(super) fn interpolated(mut at: impl FnMut(f64) -> Option<Vec<Number>>) -> Option<(Vec<f64>, Vec<f64>)> {
    let mut sums: Vec<[Number; 2]> = Vec::new();
    for (k, (weight, inner)) in WEIGHTS.into_iter().zip(INNER_WEIGHTS).enumerate() {
        for sign in [-1.0, 1.0] {
            let values = at(sign * (k + 1) as f64)?;
            sums.resize(values.len(), [Number::zero(); 2]);
            for ([sum, of_inner], value) in sums.iter_mut().zip(values) {
                *sum = *sum + Number::from(weight) * value;
                *of_inner = *of_inner + Number::from(inner) * value;
            }
        }
    }
    let difference = |[sum, inner]: &[Number; 2]| (*sum - *inner).to_f64();
    Some((sums.iter().map(|[sum, _]| sum.to_f64()).collect(), sums.iter().map(difference).collect()))
}
