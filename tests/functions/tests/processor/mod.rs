//! The property of the processor on which results depend.

/// Whether the processor has lanes of eight numbers.
///
/// The scene `rubbing` has too many operations for lanes of four: others make its designs one by one, and its steps by
/// gauss with another method.
pub(crate) fn has_lanes_of_eight() -> bool {
    #[cfg(target_arch = "x86_64")]
    return is_x86_feature_detected!("avx512f");
    #[cfg(not(target_arch = "x86_64"))]
    return false;
}
