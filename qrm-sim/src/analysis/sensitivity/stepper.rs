//! Steps on dual numbers, from one corner of the equations of motion to the next.

use qrm_core::{Mechanism, Scalar, Tape};

use super::SensitivityRequest;
use super::crossing::crossing;
use super::equations::{DualEquations, DualState};
use super::error::SensitivityError;
use super::number::{Inner, Number};
use super::{collocation, explicit, rosenbrock};
use crate::integrate::{Corner, Corners, Formula, JUMP_MARGIN, MOST_PARTS, StepError};

/// A corner is crossed where it is as near as this part of the step.
const NEAR: f64 = 1e-6;
/// A corner is crossed from this distance before it to this distance behind it: `CROSSING_DISTANCE` of the step or
/// `LEAST` of the time, whichever is larger.
const CROSSING_DISTANCE: f64 = 1e-10;
const LEAST: f64 = 1e-12;

/// Makes steps with derivatives by parameters.
pub(super) struct DualStepper<'m, T: Inner> {
    pub(super) equations: DualEquations<'m, T>,
    /// The corners of the equations of motion; `None` if there are none.
    corners: Option<Corners>,
    /// The switching functions.
    switching: Vec<Number<T>>,
}

impl<'m, T: Inner> DualStepper<'m, T> {
    pub(super) fn new(
        mechanism: &'m dyn Mechanism,
        tape: &'m Tape,
        parts: usize,
        request: &SensitivityRequest,
    ) -> Self {
        Self {
            equations: DualEquations::new(mechanism, tape, parts, request),
            corners: Corners::new(mechanism),
            switching: vec![Number::zero(); tape.switching_functions.results.len()],
        }
    }

    /// The state at `t`, by one step or by several ones that end where the equations of motion have a corner.
    ///
    /// The time of a corner depends on the parameters, and so do the lengths of the steps beside it: where the
    /// accelerations jump, the derivatives do as well.
    ///
    /// # Errors
    /// A step cannot be made, or its end has no derivatives.
    pub(super) fn advance(
        &mut self,
        formula: Formula,
        from: &DualState<T>,
        t: Number<T>,
    ) -> Result<DualState<T>, SensitivityError> {
        let Some(mut corners) = self.corners.take() else { return self.step(formula, from, t) };
        let made = self.advance_split_at_corners(formula, &mut corners, from.clone(), t);
        self.corners = Some(corners);
        made
    }

    fn advance_split_at_corners(
        &mut self,
        formula: Formula,
        corners: &mut Corners,
        mut now: DualState<T>,
        t: Number<T>,
    ) -> Result<DualState<T>, SensitivityError> {
        let end = t.to_f64();
        let whole = (end - now.t.to_f64()).abs();
        // A state beside a corner stands for the one at the end, where the corner is too near to be crossed.
        let beside = |before: f64| t + Number::from_f64(before - end);
        for _ in 0..MOST_PARTS {
            let begin = now.t.to_f64();
            if let Some(corner) = corners.at(begin) {
                let (before, behind) = (corner.just_before(), corner.just_after());
                if behind > end {
                    return self.step(formula, &now, beside(begin));
                }
                now = if begin == before {
                    self.cross(formula, &now, [before, behind])?
                } else {
                    self.moved(&now, behind - begin)?
                };
                continue;
            }
            if corners.is_at(&now.real()) {
                now = self.moved_off_zero(corners, now, CROSSING_DISTANCE * whole)?;
            }
            let known = corners.next_time(begin).filter(|corner| corner.just_before() < end);
            let part_end = match known {
                Some(corner) if corner.just_after() > end => beside(corner.just_before()),
                Some(corner) => Number::from_f64(corner.just_before()),
                None => t,
            };
            let to = self.step(formula, &now, part_end)?;
            let Some(found) = self.corner_inside(formula, corners, [&now, &to])? else {
                if known.is_none_or(|corner| corner.just_after() > end) {
                    return Ok(to);
                }
                now = to;
                continue;
            };
            let distance = (CROSSING_DISTANCE * whole).max(LEAST * found.abs());
            let (before, behind) = (found - distance, found + distance);
            if found - begin > (NEAR * whole).max(2.0 * distance) {
                now = self.step(formula, &now, Number::from_f64(found - JUMP_MARGIN * (found - begin)))?;
            } else if behind > end {
                return self.step(formula, &now, beside(before));
            } else {
                now = self.cross(formula, &now, [before, behind])?;
                corners.forget();
            }
        }
        self.step(formula, &now, t)
    }

    /// The time of the first corner that the motion meets in a step.
    fn corner_inside(
        &mut self,
        formula: Formula,
        corners: &mut Corners,
        [from, to]: [&DualState<T>; 2],
    ) -> Result<Option<f64>, SensitivityError> {
        let (begin, end) = (from.real(), to.real());
        if !corners.may_meet(&begin.as_ref(), &end.as_ref()) {
            return Ok(None);
        }
        let found = corners.first_inside([&begin, &end], 0.0, &mut |t| {
            self.stepped(formula, from, Number::from_f64(t)).map(|at| at.real())
        });
        let found = found.map_err(|error| SensitivityError::Step { t: begin.t, error })?;
        Ok(found.map(|found| found.t))
    }

    /// The state behind a corner, from a state before it. The time before it follows the parameters as the corner does.
    fn cross(
        &mut self,
        formula: Formula,
        from: &DualState<T>,
        [before, behind]: [f64; 2],
    ) -> Result<DualState<T>, SensitivityError> {
        let at = self.step(formula, from, Number::from_f64(before))?.real();
        let mut values = vec![Scalar::zero(); self.switching.len()];
        self.equations.along_motion(&at, |moving, t, q, qd| moving.switching_functions(t, q, qd, &mut values));
        // The function that is zero at the corner, and its derivative by time.
        let distance = |i: &usize| (values[*i].0.re / values[*i].0.eps).abs();
        let nearest = (0..values.len()).filter(|i| !distance(i).is_nan());
        let nearest = nearest.min_by(|a, b| distance(a).total_cmp(&distance(b)));
        let place = nearest.ok_or(SensitivityError::NotSmooth { t: before })?;
        let by_time = values[place].0.eps;
        let at = crossing((before, by_time, self.equations.parts), |t| {
            let at = self.step(formula, from, t)?;
            self.equations.evaluator.switching_functions(at.t, &at.q, &at.qd, &mut self.switching);
            Ok((at, self.switching[place]))
        })?;
        self.moved(&at, behind - before)
    }

    /// A state at a corner moved so far that it is behind it; the same state if that is further than `longest`.
    fn moved_off_zero(
        &mut self,
        corners: &mut Corners,
        from: DualState<T>,
        longest: f64,
    ) -> Result<DualState<T>, SensitivityError> {
        let t = from.t.to_f64();
        let mut far = Corner(t).just_after() - t;
        while far <= longest {
            let moved = self.moved(&from, far)?;
            if !corners.is_at(&moved.real()) {
                return Ok(moved);
            }
            far *= 4.0;
        }
        Ok(from)
    }

    /// A state moved along its rates and accelerations by a time so short that nothing else changes.
    fn moved(&mut self, from: &DualState<T>, h: f64) -> Result<DualState<T>, SensitivityError> {
        let h = Number::from_f64(h);
        let end = from.place().plus(h, [(0, 1.0)], &[from.slope()]);
        let made = self.equations.projected(from.t + h, end.q, end.qd);
        self.equations.checked(from.t, made)
    }

    /// The state at `t` by one step.
    fn step(&mut self, formula: Formula, from: &DualState<T>, t: Number<T>) -> Result<DualState<T>, SensitivityError> {
        let made = self.stepped(formula, from, t);
        self.equations.checked(from.t, made)
    }

    fn stepped(&mut self, formula: Formula, from: &DualState<T>, t: Number<T>) -> Result<DualState<T>, StepError> {
        match formula {
            Formula::Explicit(tableau) => explicit::step(tableau, &mut self.equations, from, t),
            Formula::Rosenbrock => rosenbrock::step(&mut self.equations, from, t),
            Formula::Gauss => collocation::step(&mut self.equations, from, t),
        }
    }
}
