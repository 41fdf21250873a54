//! Matrices of intervals.

use std::ops::Range;

use nalgebra::DMatrix;
use qrm_core::Interval;

/// A matrix of intervals, row by row.
#[derive(Clone, Debug)]
pub(super) struct IntervalMatrix {
    rows: usize,
    columns: usize,
    entries: Vec<Interval>,
}

impl IntervalMatrix {
    /// The matrix with these entries.
    pub(super) fn from_fn(rows: usize, columns: usize, mut entry: impl FnMut(usize, usize) -> Interval) -> Self {
        let entries = (0..rows * columns).map(|k| entry(k / columns, k % columns)).collect();
        Self { rows, columns, entries }
    }

    /// The doubles of a matrix.
    pub(super) fn from_matrix(matrix: &DMatrix<f64>) -> Self {
        Self::from_fn(matrix.nrows(), matrix.ncols(), |i, j| Interval::point(matrix[(i, j)]))
    }

    /// The identity.
    pub(super) fn identity(size: usize) -> Self {
        Self::from_fn(size, size, |i, j| if i == j { Interval::ONE } else { Interval::ZERO })
    }

    pub(super) fn rows(&self) -> usize {
        self.rows
    }

    pub(super) fn columns(&self) -> usize {
        self.columns
    }

    pub(super) fn at(&self, i: usize, j: usize) -> Interval {
        self.entries[i * self.columns + j]
    }

    pub(super) fn row(&self, i: usize) -> &[Interval] {
        &self.entries[i * self.columns..][..self.columns]
    }

    pub(super) fn column(&self, j: usize) -> Vec<Interval> {
        (0..self.rows).map(|i| self.at(i, j)).collect()
    }

    /// A range of its columns.
    pub(super) fn part(&self, columns: Range<usize>) -> Self {
        Self::from_fn(self.rows, columns.len(), |i, j| self.at(i, columns.start + j))
    }

    /// Whether all entries are finite.
    pub(super) fn is_finite(&self) -> bool {
        self.entries.iter().all(|entry| entry.is_finite())
    }

    /// Doubles inside, near the middle.
    pub(super) fn mid(&self) -> DMatrix<f64> {
        DMatrix::from_fn(self.rows, self.columns, |i, j| self.at(i, j).mid())
    }

    /// The product with another matrix.
    pub(super) fn times(&self, other: &Self) -> Self {
        Self::from_fn(self.rows, other.columns, |i, j| dot(self.row(i), (0..other.rows).map(|k| other.at(k, j))))
    }

    /// The product with a vector.
    pub(super) fn applied(&self, vector: &[Interval]) -> Vec<Interval> {
        (0..self.rows).map(|i| dot(self.row(i), vector.iter().copied())).collect()
    }
}

/// The sum of two vectors.
pub(super) fn sum(a: &[Interval], b: &[Interval]) -> Vec<Interval> {
    a.iter().zip(b).map(|(a, b)| *a + *b).collect()
}

/// The negative of a vector.
pub(super) fn negative(a: &[Interval]) -> Vec<Interval> {
    a.iter().map(|a| -*a).collect()
}

fn dot(a: &[Interval], b: impl Iterator<Item = Interval>) -> Interval {
    a.iter().zip(b).fold(Interval::ZERO, |sum, (a, b)| sum + *a * b)
}
