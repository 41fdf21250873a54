//! The motion between the rows of a run, for extremes of many columns.

use std::f64::consts::PI;

use qrm_core::{Mechanism, RowLayout};

use crate::integrate::Integrator;
use crate::polynomial::Polynomial;
use crate::solve::{IRREGULAR, largest};
use crate::state::State;

/// The number of candidates between two rows from which the motion is interpolated near a singular position, and
/// elsewhere.
const MANY: usize = 16;
const VERY_MANY: usize = 64;
/// The number of states of an interpolation.
const NODES: usize = 6;
/// The part of the distance between two rows at which an interpolation is compared with the motion.
const COMPARED: f64 = 0.3;
/// The largest error of an interpolation, relative to the largest number of its kind.
const SMOOTH: f64 = 1e-11;
/// The number of times that a steep span near a singular position is halved.
const HALVINGS: usize = 3;

/// The motion between rows: each state is a step from the last row before it.
///
/// Where many columns turn between two rows, as in mechanisms of many coordinates, few states are computed, and others
/// are interpolated.
pub(super) struct MotionBetweenRows<'r> {
    mechanism: &'r dyn Mechanism,
    integrator: Integrator,
    layout: RowLayout,
    /// Rows in lists, each by increasing time.
    rows: [&'r [f64]; 4],
    /// The times between which candidates lie.
    brackets: Vec<[f64; 2]>,
    spans: Vec<Span>,
    /// A buffer for a row.
    from: State,
}

/// The time between two rows, or a part of it.
struct Span {
    ends: [f64; 2],
    /// `None` where the motion is evaluated.
    polynomials: Option<Polynomials>,
}

/// The polynomials of a span.
struct Polynomials {
    /// Those of coordinates, rates, accelerations and multipliers; `None` where accelerations or multipliers are steep
    /// or mostly rounding errors.
    parts: [Option<Vec<Polynomial<f64>>>; 4],
    /// Whether a part without polynomials is evaluated: near a singular position that would take seconds.
    evaluates: bool,
}

impl<'r> MotionBetweenRows<'r> {
    /// The motion of an integrator, which is copied, so that the run itself is not affected.
    pub(super) fn new(
        mechanism: &'r dyn Mechanism,
        run: &Integrator,
        layout: RowLayout,
        rows: [&'r [f64]; 4],
        brackets: Vec<[f64; 2]>,
    ) -> Self {
        let from = State::zero(layout.n, layout.m);
        Self { mechanism, integrator: run.clone(), layout, rows, brackets, spans: Vec::new(), from }
    }

    /// The state at a time, for a column; `None` before the first row, and where the motion cannot be continued to.
    pub(super) fn at(&mut self, t: f64, column: usize) -> Option<State> {
        let before = self.rows.into_iter().filter_map(|rows| self.place(rows, t).checked_sub(1).map(|k| (rows, k)));
        let (rows, k) = before.max_by(|a, b| self.time(*a).total_cmp(&self.time(*b)))?;
        let begin = self.time((rows, k));
        if begin < t
            && self.brackets.len() >= MANY
            && let Some(state) = self.interpolated((rows, k), [begin, self.next_time(t)], (t, column))
        {
            return Some(state);
        }
        self.evaluated((rows, k), t)
    }

    /// The time at which multipliers grew without bound, if a state met one.
    pub(super) fn unbounded_at(&self) -> Option<f64> {
        self.integrator.stats().unbounded_at
    }

    /// The state by a step from a row.
    fn evaluated(&mut self, (rows, k): (&[f64], usize), t: f64) -> Option<State> {
        self.from.read(&rows[k * self.layout.width()..]);
        self.integrator.between(self.mechanism, &self.from, t).ok()
    }

    /// The state by interpolation; `None` where few candidates lie, or where what the column needs is not smooth.
    fn interpolated(&mut self, row: (&[f64], usize), ends: [f64; 2], at: (f64, usize)) -> Option<State> {
        let contains = |span: &&Span| span.ends[0] <= at.0 && at.0 <= span.ends[1];
        if let Some(span) = self.spans.iter().find(contains) {
            return span.state(self.layout, at);
        }
        let is_here = |bracket: &&[f64; 2]| bracket[0] < ends[1] && ends[0] < bracket[1];
        let count = self.brackets.iter().filter(is_here).count();
        if count < MANY {
            return None;
        }
        self.add_spans(row, ends, count >= VERY_MANY, HALVINGS);
        self.spans.iter().find(contains)?.state(self.layout, at)
    }

    /// Adds the span between two times after a row, in halves if it is steep near a singular position.
    fn add_spans(&mut self, row: (&[f64], usize), ends: [f64; 2], is_wanted: bool, halvings: usize) {
        let polynomials = ends[1].is_finite().then(|| self.polynomials(row, ends, is_wanted)).flatten();
        let is_steep = |found: &Polynomials| !found.evaluates && found.parts.iter().any(Option::is_none);
        if halvings > 0 && polynomials.as_ref().is_some_and(is_steep) {
            let middle = 0.5 * (ends[0] + ends[1]);
            for half in [[ends[0], middle], [middle, ends[1]]] {
                self.add_spans(row, half, is_wanted, halvings - 1);
            }
        } else {
            self.spans.push(Span { ends, polynomials });
        }
    }

    /// The polynomials through states at Chebyshev's points with both ends; `None` if the motion is not smooth, or if
    /// no singular position is near and they are not wanted elsewhere. The first point of a span behind a row is the
    /// row: rounding errors of an interpolation move no extreme away from it.
    fn polynomials(&mut self, row: (&[f64], usize), [begin, end]: [f64; 2], is_wanted: bool) -> Option<Polynomials> {
        let compared = self.evaluated(row, begin + COMPARED * (end - begin))?;
        let State { t, q, qd, .. } = &compared;
        let solver = self.integrator.solver_mut();
        let is_near = solver.singularity_fraction(self.mechanism, IRREGULAR, *t, (q, qd)).is_some();
        if !is_wanted && !is_near {
            return None;
        }
        let part = |k: usize| 0.5 - 0.5 * (PI * k as f64 / (NODES - 1) as f64).cos();
        let nodes: Option<Vec<State>> =
            (0..NODES).map(|k| self.evaluated(row, begin + part(k) * (end - begin))).collect();
        let nodes = nodes?;
        let through = |numbers: fn(&State) -> &[f64]| -> Option<Vec<Polynomial<f64>>> {
            let size = largest(numbers(&compared)).1;
            let polynomial = |i: usize| {
                let points: Vec<_> = nodes.iter().map(|node| (node.t, numbers(node)[i])).collect();
                let polynomial = Polynomial::through(&points);
                let difference = (polynomial.value(compared.t) - numbers(&compared)[i]).abs();
                (difference <= SMOOTH * size).then_some(polynomial)
            };
            (0..numbers(&compared).len()).map(polynomial).collect()
        };
        let parts = [
            Some(through(|state| &state.q)?),
            Some(through(|state| &state.qd)?),
            through(|state| &state.qdd),
            through(|state| &state.multipliers),
        ];
        Some(Polynomials { parts, evaluates: !is_near })
    }

    /// The number of rows until a time.
    fn place(&self, rows: &[f64], t: f64) -> usize {
        let (mut begin, mut end) = (0, rows.len() / self.layout.width());
        while begin < end {
            let middle = (begin + end) / 2;
            if self.time((rows, middle)) <= t { begin = middle + 1 } else { end = middle }
        }
        begin
    }

    /// The time of the first row after a time; infinite behind the last one.
    fn next_time(&self, t: f64) -> f64 {
        let after = self.rows.into_iter().map(|rows| (rows, self.place(rows, t)));
        let after = after.filter(|(rows, k)| k * self.layout.width() < rows.len());
        after.map(|row| self.time(row)).fold(f64::INFINITY, f64::min)
    }

    fn time(&self, (rows, k): (&[f64], usize)) -> f64 {
        rows[k * self.layout.width()]
    }
}

impl Span {
    /// The state at a time for a column; `None` if it is to be evaluated.
    fn state(&self, RowLayout { n, m }: RowLayout, (t, column): (f64, usize)) -> Option<State> {
        let mut state = State { t, ..State::zero(n, m) };
        let is_needed = match column {
            _ if column > 3 * n + m => [true; 4],
            _ if column > 3 * n => [false, false, false, true],
            _ => [false, false, column.is_multiple_of(3), false],
        };
        let numbers = [&mut state.q, &mut state.qd, &mut state.qdd, &mut state.multipliers];
        let Polynomials { parts, evaluates } = self.polynomials.as_ref()?;
        for ((numbers, part), is_needed) in numbers.into_iter().zip(parts).zip(is_needed) {
            match part {
                Some(own) => numbers.iter_mut().zip(own).for_each(|(number, own)| *number = own.value(t)),
                None if *evaluates && is_needed => return None,
                None => numbers.fill(f64::NAN),
            }
        }
        Some(state)
    }
}
