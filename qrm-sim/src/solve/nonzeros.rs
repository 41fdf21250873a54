//! The places of the entries of a matrix that are not zero.

/// The columns of the nonzero entries of each row of a matrix.
///
/// Constraints contain few coordinates. The matrices of mechanisms with many bodies are stored densely, and most sums
/// over a row have few terms.
#[derive(Clone, Debug, Default)]
pub(super) struct Nonzeros {
    columns: Vec<usize>,
    /// The end of each row in `columns`.
    ends: Vec<usize>,
}

impl Nonzeros {
    /// Finds the entries of these rows that are not zero.
    pub(super) fn find<'r, T: Default + PartialEq + 'r>(&mut self, rows: impl Iterator<Item = &'r [T]>) {
        let zero = T::default();
        self.columns.clear();
        self.ends.clear();
        for row in rows {
            self.columns.extend((0..row.len()).filter(|&j| row[j] != zero));
            self.ends.push(self.columns.len());
        }
    }

    /// The columns of the nonzero entries of a row, in ascending order.
    pub(super) fn row(&self, i: usize) -> &[usize] {
        let begin = if i == 0 { 0 } else { self.ends[i - 1] };
        &self.columns[begin..self.ends[i]]
    }

    /// The columns of the nonzero entries of a row before its diagonal entry.
    pub(super) fn before_diagonal(&self, i: usize) -> &[usize] {
        let row = self.row(i);
        &row[..row.partition_point(|&j| j < i)]
    }

    /// The columns of the nonzero entries of a row after its diagonal entry.
    pub(super) fn after_diagonal(&self, i: usize) -> &[usize] {
        let row = self.row(i);
        &row[row.partition_point(|&j| j <= i)..]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_found_with_their_diagonal() {
        let mut nonzeros = Nonzeros::default();
        for _ in 0..2 {
            nonzeros.find([0.0, 2.0, 0.0, 3.0, f64::NAN, 0.0, 0.0, 0.0, -0.0].chunks_exact(3));
            assert_eq!([0, 1, 2].map(|i| nonzeros.row(i)), [&[1][..], &[0, 1], &[]]);
            assert_eq!([nonzeros.before_diagonal(1), nonzeros.after_diagonal(1)], [&[0][..], &[]]);
            assert_eq!([nonzeros.before_diagonal(0), nonzeros.after_diagonal(0)], [&[][..], &[1]]);
        }
    }
}
