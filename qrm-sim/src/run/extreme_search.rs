//! The search for extremes between the rows of a run, on the motion itself.

use qrm_core::{Mechanism, RowLayout};

use super::extremes::{Vertex, sign};
use super::extremes_tracker::ExtremesTracker;
use super::motion_between_rows::MotionBetweenRows;
use super::outcome::{NonFiniteQuantity, Status};
use super::output_bounds::{OutputBounds, UnresolvedStep};
use crate::bounds::{PeakError, PeakSearch};
use crate::columns::number;
use crate::integrate::Integrator;
use crate::maximum::{peak_between, vertex_beside};

/// Whether extremes are searched for between rows.
pub(super) const SEARCHES: bool = cfg!(feature = "extremes");

/// The distance from a row, relative to that of rows, at which a column is tested for a rise.
const NEIGHBOUR_DISTANCE: f64 = 1e-3;

/// Differences of an output that do not count between values in one step, in parts of its range.
const ROUNDING: f64 = 1e-14;

/// The number of rows for the polynomial of an extreme.
const TAIL: usize = 5;

/// The rows of a run from which steps lead to extremes between them.
#[derive(Clone, Debug)]
pub(super) struct ExtremeSearch {
    layout: RowLayout,
    /// The first row.
    first: Vec<f64>,
    /// The rows before the last block between which extremes may still be found.
    tail: Vec<f64>,
    /// The time at which multipliers grow without bound, if a search met one.
    pub(super) unbounded_at: Option<f64>,
    /// The outputs whose extremes between rows are not known.
    pub(super) undecided: Vec<usize>,
    /// How far outputs may exceed their extremes: the output, the end and the distance.
    pub(super) open: Vec<(usize, usize, f64)>,
}

impl ExtremeSearch {
    /// Begins with a run at its first row.
    pub(super) fn new(layout: RowLayout, first: &[f64]) -> Self {
        Self {
            layout,
            first: if SEARCHES { first.to_vec() } else { Vec::new() },
            tail: Vec::new(),
            unbounded_at: None,
            undecided: Vec::new(),
            open: Vec::new(),
        }
    }

    /// Searches for each extreme between rows; `rows` are the last ones.
    ///
    /// # Errors
    /// An output is not defined at a time.
    pub(super) fn refine(
        &mut self,
        mechanism: &dyn Mechanism,
        run: &Integrator,
        rows: &[f64],
        (extremes, bounds): (&mut ExtremesTracker, Option<&mut OutputBounds>),
    ) -> Result<(), Status> {
        if !SEARCHES {
            extremes.note_estimates();
            return Ok(());
        }
        self.refine_vertices(mechanism, run, rows, extremes);
        match bounds {
            Some(bounds) if !extremes.found().is_empty() => self.refine_outputs(mechanism, run, bounds, extremes),
            _ => Ok(()),
        }
    }

    /// Searches for the extremes that polynomials through rows show.
    fn refine_vertices(
        &mut self,
        mechanism: &dyn Mechanism,
        run: &Integrator,
        rows: &[f64],
        extremes: &mut ExtremesTracker,
    ) {
        let vertices = extremes.take_vertices();
        if vertices.is_empty() {
            return;
        }
        let rows = [rows, run.inner_rows(), &self.tail, &self.first];
        let brackets = vertices.iter().map(|vertex| vertex.bracket).collect();
        let mut motion = MotionBetweenRows::new(mechanism, run, self.layout, rows, brackets);
        for vertex in vertices {
            if !extremes.may_be_extreme(&vertex) {
                continue;
            }
            let Vertex { column, end, estimate, bracket, .. } = vertex;
            let t = estimate.1;
            let sign = sign(end);
            let mut value = |t: f64| {
                let at = motion.at(t, column)?;
                Some(sign * number(mechanism, &at, column)).filter(|value| value.is_finite())
            };
            let at = value(t);
            // A value at an end is an extreme, unless the column rises from there.
            let other = bracket[0] + bracket[1] - t;
            if bracket.contains(&t) && !(value(t + NEIGHBOUR_DISTANCE * (other - t)) > at) {
                continue;
            }
            if at.is_some_and(|at| extremes.is_below(&vertex, sign * at)) {
                continue;
            }
            let peak = at.and_then(|at| {
                if vertex.agrees(sign * at) { Some((t, at)) } else { peak_between(bracket, (t, at), &mut value) }
            });
            let mut found = peak.map_or(estimate, |(t, value)| (sign * value, t));
            if extremes.replaces(&vertex, found) {
                let (t, value) = vertex_beside((found.1, sign * found.0), bracket, &mut value);
                found = (sign * value, t);
            }
            extremes.note(&vertex, found);
        }
        self.unbounded_at = self.unbounded_at.or(motion.unbounded_at());
    }

    /// Searches for the extremes of outputs that may change faster between samples than the motion does.
    fn refine_outputs(
        &mut self,
        mechanism: &dyn Mechanism,
        run: &Integrator,
        bounds: &mut OutputBounds,
        extremes: &mut ExtremesTracker,
    ) -> Result<(), Status> {
        let mut integrator = None;
        for which in 0..bounds.outputs.len() {
            let output = bounds.outputs[which].0.output;
            let column = 1 + 3 * self.layout.n + self.layout.m + output;
            for UnresolvedStep { step, ends } in bounds.unresolved(which, &extremes.found()[column]) {
                let [from, to] = [step, step + 1].map(|sample| bounds.state(sample));
                // Copies, so that the run itself is not affected.
                let integrator = integrator.get_or_insert_with(|| run.clone());
                let mut solver = integrator.solver().clone();
                for end in (0..2).filter(|&end| ends[end]) {
                    let known = extremes.found()[column];
                    let (sign, best) = if end == 0 { (-1.0, known.minimum) } else { (1.0, known.maximum) };
                    let (own, left) = &mut bounds.outputs[which];
                    let mut search = PeakSearch {
                        mechanism,
                        bounds: &mut own.bounds,
                        solver: Some(&mut solver),
                        sign,
                        ends: [&from, &to],
                        best: (sign * best.0, best.1),
                        tie: ROUNDING * known.range(),
                        open: 0.0,
                        left,
                        at: &mut |t| integrator.between(mechanism, &from, t).ok(),
                        value: &mut |at| number(mechanism, at, column),
                    };
                    let searched = search.search();
                    let (value, t) = search.best;
                    if search.open > 0.0 {
                        self.open.push((output, end, search.open));
                    }
                    let found = (sign * value, t);
                    let bracket = [from.t, to.t];
                    let vertex =
                        Vertex { column, end, estimate: found, bracket, value_uncertainty: 0.0, agreement: None };
                    extremes.note(&vertex, found);
                    match searched {
                        Ok(()) => {}
                        Err(PeakError::Undefined(t)) => {
                            return Err(Status::NotFinite { t, what: NonFiniteQuantity::Output(output) });
                        }
                        Err(PeakError::Undecided) if self.undecided.contains(&output) => {}
                        Err(PeakError::Undecided) => self.undecided.push(output),
                    }
                }
            }
        }
        self.undecided.iter().for_each(|output| bounds.leave_out(*output));
        bounds.forget();
        Ok(())
    }

    /// Keeps the last rows; the very last one is also the first of the next block.
    pub(super) fn keep(&mut self, rows: &[f64]) {
        if !SEARCHES {
            return;
        }
        let width = self.layout.width();
        let made = rows.len() / width - 1;
        self.tail.extend_from_slice(&rows[made.saturating_sub(TAIL) * width..made * width]);
        let excess = self.tail.len().saturating_sub(TAIL * width);
        self.tail.drain(..excess);
    }
}
