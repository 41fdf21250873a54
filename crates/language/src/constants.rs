//! Constants of the projection, shared by the templates of all languages and the steps in Rust.

use qrm_core::{CORRECTION_ROUNDING, MAX_CORRECTIONS, MAX_GROWTH, RESIDUAL_ROUNDING};

/// Replaces the constants in a template by their values.
pub(super) fn substitute(template: &str) -> String {
    template
        .replace("QRM_MAX_CORRECTIONS", &MAX_CORRECTIONS.to_string())
        .replace("QRM_RESIDUAL_ROUNDING", &format!("{RESIDUAL_ROUNDING:e}"))
        .replace("QRM_CORRECTION_ROUNDING", &format!("{CORRECTION_ROUNDING:e}"))
        .replace("QRM_MAX_GROWTH", &format!("{MAX_GROWTH:e}"))
}
