//! Records a run for pictures and reports, in bounded memory for any length of the run.

use std::io;

use qrm_core::Description;
use qrm_sim::columns::{Column, Kind, columns};
use qrm_sim::run::{Extremes, Observer, Row};
use qrm_view::envelope::Envelope;

/// The largest number of frames for an animation; long runs have at least half as many.
const MAX_FRAMES: usize = 1500;

/// An observer that records the series of every column, and some complete rows.
pub struct Recording {
    columns: Vec<Column>,
    envelope: Envelope,
    /// The extremes of the first columns, that is, of all except checks.
    extremes: Vec<Extremes>,
    corrections: Envelope,
    last_corrections: f64,
    /// Equidistant rows for an animation.
    pub frames: Vec<Frame>,
    most_frames: usize,
    /// The interval, in rows, between recorded frames.
    every: u64,
    /// Whether series are kept.
    has_series: bool,
}

/// The numbers of a row, in the order of the columns.
pub type Frame = Vec<f64>;

impl Recording {
    /// Creates an empty recording for a run of this mechanism.
    pub fn new(description: &Description) -> Self {
        Self::with_frames(description, MAX_FRAMES)
    }

    /// Creates an empty recording for a run of this mechanism, with at most `most_frames` frames.
    pub fn with_frames(description: &Description, most_frames: usize) -> Self {
        let columns = columns(description);
        Self {
            columns,
            envelope: Envelope::default(),
            extremes: Vec::new(),
            corrections: Envelope::default(),
            last_corrections: 0.0,
            frames: Vec::new(),
            most_frames,
            every: 1,
            has_series: true,
        }
    }

    /// Creates an empty recording for a run of this mechanism that records only extremes: no series and no frames.
    pub fn for_extremes(description: &Description) -> Self {
        Self { has_series: false, ..Self::with_frames(description, 0) }
    }

    /// The columns of the rows.
    pub fn columns(&self) -> impl Iterator<Item = &Column> {
        self.columns.iter()
    }

    /// The values of a column in the frames.
    pub fn values(&self, kind: Kind) -> Vec<f64> {
        let place = self.place(kind);
        place.map_or(Vec::new(), |place| self.frames.iter().map(|frame| frame[place]).collect())
    }

    /// The value of a column in a frame; not a number if there is no such column.
    pub fn value(&self, frame: usize, kind: Kind) -> f64 {
        self.place(kind).map_or(f64::NAN, |place| self.frames[frame][place])
    }

    /// Times and values of a column, including every peak of a long run.
    pub fn series(&self, kind: Kind) -> Vec<(f64, f64)> {
        self.place(kind).map(|place| self.envelope.points(place)).unwrap_or_default()
    }

    /// The extremes of a column; `None` for checks.
    pub fn extremes(&self, kind: Kind) -> Option<Extremes> {
        self.place(kind).and_then(|place| self.extremes.get(place).copied())
    }

    /// Times, and the numbers of corrections of the coordinates.
    pub fn corrections(&self) -> Vec<(f64, f64)> {
        self.corrections.points(0)
    }

    /// Time, coordinates and rates of each frame.
    pub fn states(&self) -> Vec<(f64, Vec<f64>, Vec<f64>)> {
        let values = |frame: &Frame, is_wanted: fn(Kind) -> bool| {
            let wanted = frame.iter().zip(&self.columns).filter(|(_, column)| is_wanted(column.kind));
            wanted.map(|(value, _)| *value).collect()
        };
        let state = |frame: &Frame| {
            let q = values(frame, |kind| matches!(kind, Kind::Coordinate(_)));
            (frame[0], q, values(frame, |kind| matches!(kind, Kind::Rate(_))))
        };
        self.frames.iter().map(state).collect()
    }

    fn place(&self, kind: Kind) -> Option<usize> {
        self.columns.iter().position(|column| column.kind == kind)
    }
}

impl Observer for Recording {
    fn row(&mut self, row: &Row) -> io::Result<()> {
        if !self.has_series {
            return Ok(());
        }
        self.envelope.row(row.t, row.columns);
        // No step leads to the first row.
        if row.index > 0 {
            self.last_corrections = f64::from(row.corrections);
            self.corrections.row(row.t, &[self.last_corrections]);
        }
        if row.index.is_multiple_of(self.every) {
            if self.frames.len() >= self.most_frames {
                let mut place = 0;
                self.frames.retain(|_| {
                    place += 1;
                    place % 2 == 1
                });
                self.every *= 2;
            }
            if row.index.is_multiple_of(self.every) {
                self.frames.push(row.columns.to_vec());
            }
        }
        Ok(())
    }

    fn wants_extremes(&self) -> bool {
        true
    }

    fn extremes(&mut self, extremes: &[Extremes]) {
        self.extremes = extremes.to_vec();
    }

    fn finish(&mut self, last: &[f64]) -> io::Result<()> {
        let Some(t) = last.first().filter(|_| self.has_series) else { return Ok(()) };
        self.envelope.finish(*t, last);
        self.corrections.finish(*t, &[self.last_corrections]);
        // The last row is always a frame.
        if self.frames.last().is_some_and(|frame| frame[0] < *t) {
            self.frames.push(last.to_vec());
        }
        Ok(())
    }
}
