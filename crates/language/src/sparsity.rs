//! Which matrices are written by their entries that are not zero.

/// Matrices with more entries than this are written by those that are not zero, if these are few.
const LARGE: usize = 100;

/// Whether a matrix is written by its entries that are not zero.
pub(crate) fn is_sparse(entries: usize, filled: usize) -> bool {
    entries > LARGE && filled < entries / 4
}
