//! What pictures need of a run, in little memory however long the run is.

use std::io;

use qrm_core::Description;

use crate::envelope::Envelope;
use crate::extremes::{Extremes, Tracker};
use crate::observer::{Observer, Row};
use crate::trajectory::{columns, numbers};

/// Most frames that are kept; at least half as many of a long run are.
const MOST_FRAMES: usize = 1500;

/// Time, coordinates and rates of a frame.
pub(crate) fn state(frame: &[f64], n: usize) -> (f64, Vec<f64>, Vec<f64>) {
    let each = |first: usize| (0..n).map(|i| frame[first + 3 * i]).collect();
    (frame[0], each(1), each(2))
}

/// An observer that keeps the course of every column, and some rows whole.
pub(crate) struct Album {
    columns: Vec<Column>,
    corrections: Envelope,
    /// Rows at equal distances, as many as an animation needs.
    pub(crate) frames: Vec<Vec<f64>>,
    /// Every how many rows one is kept.
    every: u64,
    last: Vec<f64>,
}

struct Column {
    name: String,
    envelope: Envelope,
    tracker: Tracker,
}

impl Album {
    pub(crate) fn new(description: &Description) -> Self {
        let column = |name| Column { name, envelope: Envelope::default(), tracker: Tracker::default() };
        Self {
            columns: columns(description).into_iter().map(column).collect(),
            corrections: Envelope::default(),
            frames: Vec::new(),
            every: 1,
            last: Vec::new(),
        }
    }

    /// The place of a column in a row.
    pub(crate) fn place(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|column| column.name == name)
    }

    /// The course of a column.
    pub(crate) fn course(&self, name: &str) -> Vec<(f64, f64)> {
        self.place(name).map(|i| self.columns[i].envelope.points()).unwrap_or_default()
    }

    /// How often the coordinates were corrected.
    pub(crate) fn corrections(&self) -> Vec<(f64, f64)> {
        self.corrections.points()
    }

    /// The extremes of a column.
    pub(crate) fn extremes(&self, name: &str) -> Option<Extremes> {
        self.place(name).and_then(|i| self.columns[i].tracker.finish())
    }
}

impl Observer for Album {
    fn row(&mut self, row: &Row) -> io::Result<()> {
        self.last.clear();
        self.last.extend(numbers(row));
        for (column, number) in self.columns.iter_mut().zip(&self.last) {
            column.envelope.row(row.t, *number);
            column.tracker.row(row.t, *number);
        }
        // No step leads to the first row.
        if row.index > 0 {
            self.corrections.row(row.t, f64::from(row.corrections));
        }
        if row.index.is_multiple_of(self.every) {
            if self.frames.len() == MOST_FRAMES {
                let mut place = 0;
                self.frames.retain(|_| {
                    place += 1;
                    place % 2 == 1
                });
                self.every *= 2;
            }
            if row.index.is_multiple_of(self.every) {
                self.frames.push(self.last.clone());
            }
        }
        Ok(())
    }

    fn goes_on(&mut self, _t: f64, _end_time: f64) -> io::Result<bool> {
        Ok(true)
    }

    fn finish(&mut self) -> io::Result<()> {
        // A motion is shown to its end.
        if self.frames.last().is_some_and(|frame| frame[0] < self.last[0]) {
            self.frames.push(std::mem::take(&mut self.last));
        }
        Ok(())
    }
}
