//! A block of rows, filled by the generated kernel or by the plain functions.

use qrm_core::{Mechanism, RowRequest, StopReason};

use super::super::corner::Corner;
use super::super::corners::Corners;
use super::super::step_error::StepError;
use super::{Integrator, Steps};
use crate::state::{State, state_in};

/// The number of rows that the kernel makes before they are tested for corners.
const ROWS_BETWEEN_CORNERS: usize = 16;

/// The end of a block of rows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Block {
    /// The number of rows.
    pub(crate) rows_written: usize,
    /// The reason to stop; an error if the next row could not be computed.
    pub(crate) reason: Result<StopReason, StepError>,
}

impl Integrator {
    /// Fills a block with rows after its first one, by the generated kernel if the method allows it.
    pub(crate) fn fill(&mut self, mechanism: &dyn Mechanism, request: &RowRequest, rows: &mut [f64]) -> Block {
        self.inner.clear();
        if let Steps::Adaptive(adaptive) = &mut self.steps {
            adaptive.forget_steps();
        }
        // Moved out, since the rows are borrowed together with the rest of the integrator.
        let mut pair = std::mem::replace(&mut self.pair, [State::zero(0, 0), State::zero(0, 0)]);
        let block = self.fill_with(mechanism, request, rows, &mut pair);
        self.pair = pair;
        block
    }

    fn fill_with(
        &mut self,
        mechanism: &dyn Mechanism,
        request: &RowRequest,
        rows: &mut [f64],
        [from, to]: &mut [State; 2],
    ) -> Block {
        let (layout, width) = (self.layout, self.layout.width());
        from.read(rows);
        let mut made = 0;
        loop {
            if self.is_by_kernel() {
                let rest = RowRequest { first: request.first + made as u64, ..*request };
                let room = self.rows_to_corner(&rest, rows.len() / width - made - 1, rows[made * width]);
                let result = mechanism.integrate_rk4(&rest, &mut rows[made * width..(made + room + 1) * width]);
                let smooth = self.rows_without_corner(&rows[made * width..(made + result.rows_written + 1) * width]);
                made += smooth;
                if smooth == result.rows_written && room > 0 {
                    match result.reason {
                        Some(StopReason::Full) if rows.len() >= (made + 2) * width => continue,
                        Some(reason) => return Block { rows_written: made, reason: Ok(reason) },
                        None => {}
                    }
                }
                from.read(&rows[made * width..]);
            }
            if rows.len() < (made + 2) * width {
                return Block { rows_written: made, reason: Ok(StopReason::Full) };
            }
            match self.row(mechanism, request.first + made as u64, request, from, to) {
                Err(reason) => return Block { rows_written: made, reason: Err(reason) },
                Ok(event) => {
                    made += 1;
                    to.write(&mut rows[made * width..]);
                    rows[made * width + layout.event()] = event;
                    if let Some(reason) = end_of_row(event, to, request, made, rows.len() / width) {
                        return Block { rows_written: made, reason: Ok(reason) };
                    }
                    std::mem::swap(from, to);
                }
            }
        }
    }

    /// The number of rows, at most `room`, that the kernel can make from `t` before the next known corner.
    fn rows_to_corner(&mut self, request: &RowRequest, room: usize, t: f64) -> usize {
        let Some(corners) = self.corners() else { return room };
        if corners.at(t).is_some() {
            return 0;
        }
        let end = corners.next_time(t).map_or(f64::INFINITY, Corner::just_before);
        let room = room.min(ROWS_BETWEEN_CORNERS);
        (0..room).take_while(|row| request.time(request.first + *row as u64 + 1) <= end).count()
    }

    /// The corners at which fixed steps end.
    fn corners(&mut self) -> Option<&mut Corners> {
        match &mut self.steps {
            Steps::Fixed(fixed) => fixed.corners.as_mut(),
            Steps::Adaptive(_) => None,
        }
    }

    /// The number of rows after the first one before which the motion meets no corner.
    fn rows_without_corner(&mut self, rows: &[f64]) -> usize {
        let (layout, width) = (self.layout, self.layout.width());
        let count = rows.len() / width - 1;
        let Some(corners) = self.corners() else { return count };
        let row = |i: usize| state_in(layout, &rows[i * width..]);
        (0..count).find(|i| corners.may_meet(&row(*i), &row(i + 1))).unwrap_or(count)
    }

    /// Computes the row after row `row` by the plain functions, and returns the value of the event there.
    fn row(
        &mut self,
        mechanism: &dyn Mechanism,
        row: u64,
        request: &RowRequest,
        from: &State,
        to: &mut State,
    ) -> Result<f64, StepError> {
        self.advance(mechanism, from, request.time(row + 1), to)?;
        let event = if request.watches_event { mechanism.event(&to.as_ref()) } else { None };
        Ok(event.unwrap_or(-1.0))
    }
}

fn end_of_row(event: f64, row: &State, request: &RowRequest, made: usize, room: usize) -> Option<StopReason> {
    // Written so that a value that is not a number also ends the block.
    if !(event < 0.0) {
        Some(StopReason::Event)
    } else if row.t >= request.end_time {
        Some(StopReason::End)
    } else if made + 1 == room {
        Some(StopReason::Full)
    } else {
        None
    }
}
