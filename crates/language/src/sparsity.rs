//! The criterion for matrices that are written by their nonzero entries.

/// The number of entries above which a matrix may be written by its nonzero entries, if these are few.
const LARGE: usize = 100;

/// Whether a matrix is written by its nonzero entries.
pub(crate) fn is_sparse(entries: usize, filled: usize) -> bool {
    entries > LARGE && filled < entries / 4
}
