//! Sizes of vectors.

/// The size of the vectors of a batch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Width {
    /// Eight doubles (AVX-512).
    Eight,
    /// Four doubles (AVX2).
    Four,
}
