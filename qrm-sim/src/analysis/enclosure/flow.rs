//! Taylor series of the motion.

use qrm_core::{Interval, Obstacle, Tape, TapeSeries};

use super::linear::IntervalLinearSolver;
use super::manifold::Manifold;
use super::matrix::IntervalMatrix;

/// The equations of motion, which determine the Taylor series of a motion from its state.
///
/// A state has `n` coordinates, then `n` rates. Accelerations and multipliers of each order solve `M x + C_q' w = f`,
/// `C_q x = -b`, with the matrix of order zero for all orders.
pub(super) struct Flow {
    pub(super) manifold: Manifold,
    /// The tape's `dynamics`, without derivatives and with derivatives in all directions of the state.
    series: [TapeSeries; 2],
}

/// The Taylor coefficients of a state; each is a value, followed by derivatives if requested.
#[derive(Clone, Debug)]
pub(super) struct Expansion {
    states: usize,
    width: usize,
    coefficients: Vec<Interval>,
    /// Accelerations, then multipliers, at the time of the state.
    pub(super) forces: Vec<Interval>,
}

/// The reason why a motion has no series.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NoSeries {
    /// An operation has no finite value.
    Operation(Obstacle),
    /// The accelerations are not determined.
    Singular,
}

impl Flow {
    /// Creates the equations of a tape, with some parameters replaced by index, for series up to an order.
    pub(super) fn new(tape: &Tape, replace: &dyn Fn(usize) -> Option<Interval>, order: usize) -> Self {
        let directions = 2 * tape.coordinates as usize;
        let dynamics = tape.full_dynamics();
        let series = [0, directions].map(|width| TapeSeries::new(tape, &dynamics, replace, [order, width]));
        Self { manifold: Manifold::new(tape, replace), series }
    }

    /// Expands all motions through a box of states in an interval of time, up to an order, with their derivatives;
    /// those of the state are given.
    ///
    /// # Errors
    /// Some state of the box has no accelerations, or their existence is not proved.
    pub(super) fn expand(
        &mut self,
        t: Interval,
        state: &[Interval],
        frame: Option<&IntervalMatrix>,
        order: usize,
    ) -> Result<Expansion, NoSeries> {
        let [n, m] = self.manifold.sizes();
        let series = &mut self.series[usize::from(frame.is_some())];
        let (states, width) = (2 * n, 1 + frame.map_or(0, IntervalMatrix::columns));
        let mut expansion = Expansion {
            states,
            width,
            coefficients: vec![Interval::ZERO; (order + 1) * states * width],
            forces: Vec::new(),
        };
        for (i, value) in state.iter().enumerate() {
            let coefficient = expansion.at_mut(0, i);
            coefficient[0] = *value;
            if let Some(frame) = frame {
                coefficient[1..].copy_from_slice(frame.row(i));
            }
        }
        let mut time = vec![Interval::ZERO; width];
        let mut saddle: Option<IntervalLinearSolver> = None;
        // Accelerations and multipliers of each order.
        let mut solutions: Vec<Vec<Interval>> = Vec::new();
        for k in 0..order {
            time[0] = [t, Interval::ONE].get(k).copied().unwrap_or(Interval::ZERO);
            series.set(k, 0, &time);
            (0..states).for_each(|i| series.set(k, 1 + i, expansion.at(k, i)));
            series.advance(k);
            if saddle.is_none() {
                if let Some(obstacle) = series.obstacle() {
                    return Err(NoSeries::Operation(obstacle));
                }
                saddle = Some(IntervalLinearSolver::new(&matrix(series, n, m)).ok_or(NoSeries::Singular)?);
            }
            let solution = match &saddle {
                Some(saddle) => solve(series, saddle, &solutions, [n, m, width]),
                None => Vec::new(),
            };
            let by = Interval::point((k + 1) as f64);
            for i in 0..n {
                for d in 0..width {
                    let rate = expansion.at(k, n + i)[d];
                    expansion.at_mut(k + 1, i)[d] = rate / by;
                    expansion.at_mut(k + 1, n + i)[d] = solution[i * width + d] / by;
                }
            }
            solutions.push(solution);
        }
        expansion.forces =
            solutions.first().map_or_else(Vec::new, |first| first.iter().step_by(width).copied().collect());
        Ok(expansion)
    }
}

impl Expansion {
    /// The number of components of a state.
    pub(super) fn states(&self) -> usize {
        self.states
    }

    /// A coefficient and its derivatives.
    pub(super) fn at(&self, order: usize, i: usize) -> &[Interval] {
        &self.coefficients[(order * self.states + i) * self.width..][..self.width]
    }

    fn at_mut(&mut self, order: usize, i: usize) -> &mut [Interval] {
        &mut self.coefficients[(order * self.states + i) * self.width..][..self.width]
    }

    /// The sum of the first `terms` terms of a component and of its derivatives.
    pub(super) fn sum(&self, terms: usize, i: usize, t: Interval) -> Vec<Interval> {
        let mut sum = vec![Interval::ZERO; self.width];
        for k in (0..terms).rev() {
            sum.iter_mut().zip(self.at(k, i)).for_each(|(sum, term)| *sum = *sum * t + *term);
        }
        sum
    }
}

/// The index of an entry of the saddle-point matrix in the results of `dynamics`; `None` for zero.
fn place(i: usize, j: usize, n: usize) -> Option<usize> {
    match (i < n, j < n) {
        (true, true) => Some(i * n + j),
        (true, false) => Some(n * n + n + (j - n) * n + i),
        (false, true) => Some(n * n + n + (i - n) * n + j),
        (false, false) => None,
    }
}

/// The saddle-point matrix at order zero.
fn matrix(series: &TapeSeries, n: usize, m: usize) -> IntervalMatrix {
    let entry = |i, j| place(i, j, n).map_or(Interval::ZERO, |place| series.result(0, place)[0]);
    IntervalMatrix::from_fn(n + m, n + m, entry)
}

/// Accelerations and multipliers of the next order, with their derivatives.
fn solve(
    series: &TapeSeries,
    saddle: &IntervalLinearSolver,
    solutions: &[Vec<Interval>],
    [n, m, width]: [usize; 3],
) -> Vec<Interval> {
    let (size, order) = (n + m, solutions.len());
    let mut right = vec![Interval::ZERO; size * width];
    for i in 0..size {
        let own = &mut right[i * width..][..width];
        let (from, sign) = if i < n { (n * n + i, 1.0) } else { (n * n + n + m * n + (i - n), -1.0) };
        let signed = |value: &Interval| if sign > 0.0 { *value } else { -*value };
        own.iter_mut().zip(series.result(order, from)).for_each(|(own, value)| *own = signed(value));
        for (k, solution) in solutions.iter().enumerate() {
            for j in 0..size {
                let Some(place) = place(i, j, n) else { continue };
                subtract_product(own, series.result(order - k, place), &solution[j * width..][..width]);
            }
        }
    }
    let column =
        |right: &[Interval], d: usize| -> Vec<Interval> { right.iter().skip(d).step_by(width).copied().collect() };
    let values = saddle.solve(&column(&right, 0));
    let mut solution = vec![Interval::ZERO; size * width];
    for d in 0..width {
        let mut own = column(&right, d);
        if d > 0 {
            for (i, own) in own.iter_mut().enumerate() {
                for (j, value) in values.iter().enumerate() {
                    let Some(place) = place(i, j, n) else { continue };
                    *own = *own - series.result(0, place)[d] * *value;
                }
            }
        }
        let own = if d == 0 { values.clone() } else { saddle.solve(&own) };
        own.into_iter().enumerate().for_each(|(i, value)| solution[i * width + d] = value);
    }
    solution
}

fn subtract_product(own: &mut [Interval], a: &[Interval], b: &[Interval]) {
    own[0] = own[0] - a[0] * b[0];
    for d in 1..own.len() {
        own[d] = own[d] - a[0] * b[d] - a[d] * b[0];
    }
}
