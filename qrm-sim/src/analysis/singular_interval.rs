//! A prescribed motion across a singular position.

use qrm_core::Mechanism;

use super::inverse_dynamics::{PrescribedState, with_outputs};
use crate::polynomial::Polynomial;
use crate::position::Position;
use crate::solve::{Dynamics, largest};

/// A position of the motion, and the state there.
pub(super) type Placed = (Position, PrescribedState);

/// The distances of the states on each side of the position, relative to the nearest ones.
const PLACES: [f64; 5] = [1.0, 1.5, 2.0, 2.5, 3.0];
/// The largest error of a polynomial that is used, relative to the largest number of its kind.
const SMOOTH: f64 = 1e-6;
/// The largest rounding error of a number that may be zero all the time, relative to the smallest size of its kind.
const ROUNDING: f64 = 1e-12;

/// The time near a singular position, at which the loops do not determine the state.
///
/// At a distance `d` rounding errors are magnified by `1/d^4` in the multipliers. The motion through an isolated
/// singular position is smooth, so its state is that of the polynomial of degree 9 through states on both sides.
#[derive(Clone, Debug)]
pub(super) struct SingularInterval {
    ends: [f64; 2],
    /// The state at the later end.
    after: Placed,
    /// The polynomials of coordinates, rates, accelerations, multipliers and forces.
    polynomials: [Vec<Polynomial<f64>>; 5],
    /// The largest error of the polynomials, relative to the largest number of its kind: the difference from the
    /// polynomial through all but the outermost states.
    pub(super) error: f64,
}

impl SingularInterval {
    /// Creates the interval around a time, from the states at its ends; `None` if the motion or its forces are not
    /// smooth there.
    pub(super) fn new(
        mechanism: &dyn Mechanism,
        middle: f64,
        [before, after]: [&Placed; 2],
        follow: impl Fn(&Placed, f64) -> Option<Placed>,
    ) -> Option<Self> {
        let mut states: Vec<PrescribedState> = Vec::new();
        for nearest in [before, after] {
            let distance = nearest.1.t - middle;
            let mut last = nearest.clone();
            for place in PLACES {
                if place > 1.0 {
                    last = follow(&last, middle + place * distance)?;
                }
                states.push(last.1.clone());
            }
        }
        // At a pole the error changes its sign in the middle, so it is also computed on both sides.
        let places = [-0.5, 0.0, 0.5].map(|part| middle + part * (after.1.t - middle));
        let mut error: f64 = 0.0;
        let mut through =
            |is_motion: bool, numbers: fn(&PrescribedState) -> &[f64], least: f64| -> Option<Vec<Polynomial<f64>>> {
                let size = states.iter().flat_map(numbers).fold(0.0_f64, |size, number| size.max(number.abs()));
                let polynomial = |i: usize| {
                    let points: Vec<_> = states.iter().map(|state| (state.t, numbers(state)[i])).collect();
                    let is_inner = |place: usize| place % PLACES.len() + 1 < PLACES.len();
                    let inner: Vec<_> = (0..points.len()).filter(|&k| is_inner(k)).map(|k| points[k]).collect();
                    let [polynomial, other] = [&points, &inner].map(|points| Polynomial::through(points));
                    let difference = places.map(|t| (polynomial.value(t) - other.value(t)).abs());
                    let difference = difference.into_iter().fold(0.0, f64::max);
                    let own = if is_motion { size.max(least) } else { size };
                    if difference > ROUNDING * least {
                        error = error.max(difference / own);
                    }
                    (difference <= SMOOTH * size.max(least)).then_some(polynomial)
                };
                (0..numbers(&before.1).len()).map(polynomial).collect()
            };
        // The smallest sizes to compare with, for numbers that may be zero all the time.
        let PrescribedState { t, q, qd, .. } = &before.1;
        let fastest = largest(qd).1;
        let mass = Dynamics::at(mechanism, *t, q, qd).mass_matrix.iter().map(|row| largest(row).1).fold(0.0, f64::max);
        let polynomials = [
            through(true, |state| &state.q, fastest * (after.1.t - before.1.t))?,
            through(true, |state| &state.qd, 0.0)?,
            through(true, |state| &state.qdd, fastest * fastest)?,
            through(false, |state| &state.multipliers, mass * fastest * fastest)?,
            through(false, |state| &state.forces, mass * fastest * fastest)?,
        ];
        Some(Self { ends: [before.1.t, after.1.t], after: after.clone(), polynomials, error })
    }

    /// Whether the state at a time is that of the polynomials.
    pub(super) fn contains(&self, t: f64) -> bool {
        self.ends[0] < t && t < self.ends[1]
    }

    /// Whether a prescribed motion of a coordinate from a time on is that of the polynomials: value, rate and
    /// acceleration.
    pub(super) fn agrees(&self, coordinate: usize, t: f64, prescribed: impl Fn(f64) -> [f64; 3]) -> bool {
        let [q, qd, qdd, ..] = &self.polynomials;
        let own = [q, qd, qdd].map(|polynomials| &polynomials[coordinate]);
        let duration = self.ends[1] - self.ends[0];
        [t, 0.5 * (t + self.ends[1]), self.ends[1]].into_iter().all(|t| {
            let (own, other) = (own.map(|polynomial| polynomial.value(t)), prescribed(t));
            // Sizes of the three: a coordinate moves by its rate.
            let rate = own[1].abs().max(other[1].abs());
            let sizes = [rate * duration, rate, own[2].abs().max(other[2].abs()).max(rate / duration)];
            (0..3).all(|k| (own[k] - other[k]).abs() <= SMOOTH * sizes[k])
        })
    }

    /// The motion at the later end.
    pub(super) fn after(&self) -> &Placed {
        &self.after
    }

    /// The state at a time inside; `None` if it is not finite.
    pub(super) fn state(&self, mechanism: &dyn Mechanism, t: f64) -> Option<PrescribedState> {
        let value = |polynomials: &Vec<Polynomial<f64>>| polynomials.iter().map(|own| own.value(t)).collect();
        let [q, qd, qdd, multipliers, forces] = self.polynomials.each_ref().map(value);
        let state = PrescribedState { t, q, qd, qdd, multipliers, forces, outputs: Vec::new(), error: self.error };
        with_outputs(mechanism, state)
    }
}
